"""Memory of the system, with and without psutil, in and out of a container."""

import importlib
import sys

import pytest

from adaptive_fairing.core.runtime import system_memory


def without_psutil(monkeypatch):
    def not_found(name):
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", not_found)


def test_psutil_and_the_system_itself_agree(monkeypatch):
    psutil = pytest.importorskip("psutil")
    of_psutil = system_memory._free_by_psutil()
    assert 0 < of_psutil <= psutil.virtual_memory().total + psutil.swap_memory().total
    without_psutil(monkeypatch)
    assert system_memory._free_by_psutil() is None
    if sys.platform == "linux":
        # Both read the same file; other processes take and give memory in between.
        assert system_memory.available_bytes() == pytest.approx(of_psutil, rel=0.2)
    else:
        assert system_memory.available_bytes() >= of_psutil


def test_available_memory_is_what_can_be_had_without_swapping_files_out(tmp_path):
    meminfo = tmp_path / "meminfo"
    meminfo.write_text("MemTotal: 4000 kB\nMemAvailable:  3000 kB\nSwapFree: 500 kB\nHuge: no\n")
    assert system_memory._free_on_linux(meminfo) == 1024 * 3500


@pytest.mark.skipif(sys.platform == "win32", reason="no sysconf")
def test_without_that_file_and_psutil_all_memory_of_the_machine_is_taken(tmp_path, monkeypatch):
    psutil = pytest.importorskip("psutil")
    total = psutil.virtual_memory().total
    assert system_memory._free_on_linux(tmp_path / "none") is None
    for name in ("_free_on_linux", "_free_by_psutil", "_free_in_group"):
        monkeypatch.setattr(system_memory, name, lambda: None)
    assert system_memory.available_bytes() == pytest.approx(total, rel=0.05)


def test_the_limit_of_a_container_counts(tmp_path, monkeypatch):
    of_group = system_memory._free_in_group
    assert of_group(tmp_path) is None
    (tmp_path / "memory.max").write_text("max\n")
    assert of_group(tmp_path) is None
    (tmp_path / "memory.max").write_text("1000000\n")
    (tmp_path / "memory.current").write_text("700000\n")
    (tmp_path / "memory.stat").write_text("anon 1\ninactive_file 200000\n")
    assert of_group(tmp_path) == 500_000
    monkeypatch.setattr(system_memory, "_free_in_group", lambda: of_group(tmp_path))
    assert system_memory.available_bytes() == 500_000
    (tmp_path / "memory.current").write_text("1700000\n")
    assert of_group(tmp_path) == 0


def test_a_system_that_does_not_tell_is_believed(monkeypatch):
    for name in ("_free_on_linux", "_free_by_psutil", "_free_on_windows", "_memory_of_machine"):
        monkeypatch.setattr(system_memory, name, lambda: None)
    assert system_memory.available_bytes() is None

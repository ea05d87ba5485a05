"""Memory of the system, with and without psutil, in and out of a container."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from adaptive_fairing.core.runtime import system_memory

ROOT = Path(__file__).resolve().parents[3]


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
    for name in ("_free_on_linux", "_free_by_psutil", "_free_in_groups"):
        monkeypatch.setattr(system_memory, name, lambda: None)
    assert system_memory.available_bytes() == pytest.approx(total, rel=0.05)


def write_group(folder, limit, used, cached=0, version=2):
    folder.mkdir(parents=True, exist_ok=True)
    names = ("memory.max", "memory.current", "inactive_file")
    if version == 1:
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
    (folder / names[0]).write_text(f"{limit}\n")
    (folder / names[1]).write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 1\n{names[2]} {cached}\n")


def test_the_limit_of_a_container_counts(tmp_path, monkeypatch):
    of_groups = system_memory._free_in_groups
    assert of_groups(tmp_path, tmp_path / "none") is None
    write_group(tmp_path, "max", 700_000)
    assert of_groups(tmp_path, tmp_path / "none") is None
    write_group(tmp_path, 1_000_000, 700_000, 200_000)
    assert of_groups(tmp_path, tmp_path / "none") == 500_000
    monkeypatch.setattr(
        system_memory, "_free_in_groups", lambda: of_groups(tmp_path, tmp_path / "none")
    )
    assert system_memory.available_bytes() == 500_000
    write_group(tmp_path, 1_000_000, 1_700_000)
    assert of_groups(tmp_path, tmp_path / "none") == 0


@pytest.mark.parametrize("version", [1, 2])
def test_the_least_limit_of_a_user_s_groups_counts(tmp_path, version):
    own = tmp_path / "cgroup"
    number, controllers, tree = (
        ("0", "", tmp_path) if version == 2 else ("7", "cpu,memory", tmp_path / "memory")
    )
    own.write_text(f"3:pids:/other\n{number}:{controllers}:/user.slice/session\n")
    write_group(tree / "user.slice" / "session", 900_000, 100_000, version=version)
    assert system_memory._free_in_groups(tmp_path, own) == 800_000
    write_group(tree / "user.slice", 1_000_000, 700_000, version=version)
    assert system_memory._free_in_groups(tmp_path, own) == 300_000
    # A group of something else, such as of processes, has no say.
    write_group(tmp_path / "other", 100, 50, version=version)
    assert system_memory._free_in_groups(tmp_path, own) == 300_000


@pytest.mark.skipif(sys.platform != "linux", reason="the size of a process is read from a file")
def test_a_limit_of_the_address_space_counts():
    program = (
        "import resource\n"
        "from adaptive_fairing.core.runtime import system_memory\n"
        "assert system_memory._free_in_address_space() is None\n"
        "limit = 50_000_000_000\n"
        "resource.setrlimit(resource.RLIMIT_AS, (limit, limit))\n"
        "free = system_memory._free_in_address_space()\n"
        "assert limit / 2 < free < limit, free\n"
        "assert system_memory.available_bytes() <= free\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, cwd=ROOT)


def test_a_system_that_does_not_tell_is_believed(monkeypatch):
    for name in ("_free_on_linux", "_free_by_psutil", "_free_on_windows", "_memory_of_machine"):
        monkeypatch.setattr(system_memory, name, lambda: None)
    assert system_memory.available_bytes() is None

"""Standard output and standard error kept clean, whoever writes to them."""

import ctypes
import os
import sys

import pytest

from adaptive_fairing.silence import silent_output


def write_in_every_way(text):
    """Write by Python, by the system, and by the C library, whose buffer is full later."""
    sys.stdout.write(text + "\n")
    os.write(1, text.encode())
    c_library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    c_library.printf(text.encode())


def test_nothing_comes_through_and_nothing_else_is_lost(capfd):
    write_in_every_way("before ")
    with silent_output():
        write_in_every_way("inside ")
        sys.stderr.write("inside\n")
        os.write(2, b"inside")
    sys.stderr.write("error\n")
    write_in_every_way("after ")
    ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None).fflush(None)
    out, err = capfd.readouterr()
    assert out.count("before") == 3
    assert out.count("after") == 3
    assert "inside" not in out
    assert err == "error\n"


def test_an_error_inside_turns_it_back(capfd):
    with pytest.raises(ValueError, match="bad"), silent_output():
        raise ValueError("bad")
    os.write(1, b"heard")
    assert capfd.readouterr().out == "heard"

import ctypes
import os

import numpy as np
import pytest

from modallab.jobs.stdout_guard import answers_apart


def test_what_libraries_print_does_not_reach_the_answers(capfd: pytest.CaptureFixture[str]) -> None:
    libc = ctypes.CDLL(None)
    with answers_apart():
        os.write(1, b"of a library\n")
        libc.printf(b"of C, kept back\n")
    os.write(1, b"the answer\n")
    libc.fflush(None)
    out, err = capfd.readouterr()
    assert out == "the answer\n"
    assert "of a library" in err
    assert "of C, kept back" in err


def test_lapack_complains_where_it_harms_nobody(capfd: pytest.CaptureFixture[str]) -> None:
    with answers_apart(), pytest.raises(np.linalg.LinAlgError):
        np.linalg.lstsq(np.full((4, 2), np.nan), np.ones(4), rcond=-1)
    assert capfd.readouterr().out == ""


def test_stdout_is_as_before_after_a_fault(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="ours"), answers_apart():
        raise ValueError("ours")
    os.write(1, b"the answer\n")
    assert capfd.readouterr().out == "the answer\n"

"""Redirection of library output away from a worker process's stdout."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def answers_apart() -> Iterator[None]:
    """Send what is printed meanwhile, by compiled libraries above all, to the log instead of stdout.

    A worker process answers there: LAPACK, which prints what it finds wrong with its arguments, would
    break the answer, and the job with it.
    """
    answers = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)  # C keeps lines back, and would let them go where 1 leads then
        os.dup2(answers, 1)
        os.close(answers)

"""Behaviour of the C library's allocator, where it can be told: which freed memory a process keeps."""

import ctypes
from contextlib import suppress

from modallab.api.offloading.settings import OFFLOADING

_MMAP_THRESHOLD, _ARENA_MAX = -3, -8  # of malloc.h


def return_memory_at_once() -> None:
    """Have large blocks returned to the system when they are freed, where the C library can.

    By default it keeps blocks of up to 32 MB, and a process seems to grow with each factorisation.
    """
    _tell(_MMAP_THRESHOLD, OFFLOADING.chunk_bytes)


def share_arenas() -> None:
    """Have the threads of this process allocate from few arenas, where the C library can.

    By default each of up to 8 threads a core keeps an arena with what it has freed: a service that answers
    a class grows by a fifth within minutes.
    """
    _tell(_ARENA_MAX, OFFLOADING.arenas)


def _tell(parameter: int, value: int) -> None:
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).mallopt(parameter, value)

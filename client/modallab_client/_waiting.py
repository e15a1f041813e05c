"""Functions that differ between coroutines and threads; `unasync.py` swaps the names."""

import asyncio
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import aclosing as async_closing
from contextlib import contextmanager
from typing import TypeVar

__all__ = ["async_closing", "async_run", "async_sleep", "closing", "run", "sleep"]

T = TypeVar("T")


async def async_sleep(seconds: float) -> None:
    """Return after that many seconds; other coroutines go on."""
    await asyncio.sleep(seconds)


def sleep(seconds: float) -> None:
    """Return after that many seconds."""
    time.sleep(seconds)


async def async_run(work: Callable[[], T]) -> T:
    """Return the result of blocking work without blocking other coroutines."""
    return await asyncio.to_thread(work)


def run(work: Callable[[], T]) -> T:
    """Return the result of the work."""
    return work()


@contextmanager
def closing(stream: Iterator[T]) -> Iterator[Iterator[T]]:
    """Yield an iterator that is ended with the context, if it is one that can be."""
    try:
        yield stream
    finally:
        if isinstance(stream, Generator):
            stream.close()

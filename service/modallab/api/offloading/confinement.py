"""Limits of a worker process while it answers a request: its memory and time, and where its files are."""

import os
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import psutil

from modallab.api.offloading.settings import OFFLOADING

OUT_OF_TIME, OUT_OF_MEMORY = "time", "memory"  # files that say why the process ended


@contextmanager
def confined(folder: Path) -> Iterator[None]:
    """Limit memory and time of this process until the block ends, and keep its files in a folder.

    A process that exceeds the limit ends: what a compiled library held when memory ended is not freed.
    """
    former, tempfile.tempdir = tempfile.tempdir, str(folder)
    ended = threading.Event()
    watch = threading.Thread(target=_watch, args=(ended, folder), name="limits", daemon=True)
    try:
        with _limited_data():
            watch.start()
            yield
    finally:
        ended.set()
        tempfile.tempdir = former


def end_process(folder: Path, reason: str) -> NoReturn:
    """End this process, the reason left in its folder; the service then refuses the request for it."""
    (folder / reason).touch()
    os._exit(1)


def _watch(ended: threading.Event, folder: Path) -> None:
    process, begin = psutil.Process(), time.process_time()
    while not ended.wait(OFFLOADING.watch_interval):
        if process.memory_info().rss > OFFLOADING.resident_bytes:
            end_process(folder, OUT_OF_MEMORY)
        if time.process_time() - begin > OFFLOADING.processor_seconds:
            end_process(folder, OUT_OF_TIME)


@contextmanager
def _limited_data() -> Iterator[None]:
    if sys.platform == "win32":
        yield
        return
    import resource

    # Beside the watch, and above it: a factorisation asks for far more than it fills.
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = OFFLOADING.data_bytes if hard == resource.RLIM_INFINITY else min(OFFLOADING.data_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))

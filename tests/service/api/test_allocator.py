"""Threads of a service share the memory that they free."""

import platform
import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, threading
from modallab.api.allocator import share_arenas
if {shared}:
    share_arenas()
library = ctypes.CDLL(None)
library.malloc.restype, library.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
together = threading.Barrier(12)
def allocate():
    together.wait()
    assert library.malloc(10_000)
    together.wait()
threads = [threading.Thread(target=allocate) for _ in range(12)]
for each in threads: each.start()
for each in threads: each.join()
library.fopen.restype, library.fflush.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
library.malloc_info.argtypes = [ctypes.c_int, ctypes.c_void_p]
out = library.fopen(b"/dev/stdout", b"w")
library.malloc_info(0, out)
library.fflush(out)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
@pytest.mark.parametrize("shared", [True, False])
def test_threads_share_arenas(shared: bool) -> None:
    program = [sys.executable, "-c", PROGRAM.format(shared=shared)]
    text = subprocess.run(program, capture_output=True, text=True, timeout=60, check=True).stdout
    arenas = text.count("<heap nr=")
    assert arenas <= 2 if shared else arenas > 2

"""Runs a command for as long as the process that asked for it lives, and not longer.

Started with `python _guardian.py FOLDER COMMAND...`; standard input is a pipe whose other end the
asking process holds. Whatever becomes of that process, also SIGKILL, the pipe ends with it: then the
command and all its children are ended and FOLDER, unless empty, is removed.
"""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from types import FrameType

GRACE = 10.0  # s between the polite signal and the other one
DYING = 0.3  # s killed processes get to vanish; one that nobody reaps never does


class _AskedToEnd(BaseException):
    pass


def _raise(_number: int, _frame: FrameType | None) -> None:
    raise _AskedToEnd


def _watch_the_pipe() -> None:
    os.read(sys.stdin.fileno(), 1)
    os.kill(os.getpid(), signal.SIGTERM)


def _kill_group(leader: int) -> None:
    ends = time.monotonic() + DYING
    while time.monotonic() < ends:
        try:
            os.killpg(leader, signal.SIGKILL)
        except ProcessLookupError:
            return  # all of them have ended
        time.sleep(0.01)


def _end(child: "subprocess.Popen[bytes]") -> None:
    child.terminate()  # the command alone: its children are its own to end in order
    try:
        child.wait(GRACE)
    except subprocess.TimeoutExpired:
        _kill_group(child.pid)
        child.wait()


def main(folder: str, command: list[str]) -> int:
    """Return the command's exit code, or 0 if it was ended from here."""
    signal.signal(signal.SIGTERM, _raise)
    # close_fds=False: the lock on the data folder is an inherited file, held while the command lives
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, close_fds=False)
    try:
        threading.Thread(target=_watch_the_pipe, daemon=True).start()
        code = child.wait()
        folder = ""  # the asking process still lives, and reads the log in it
    except _AskedToEnd:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        _end(child)
        code = 0
    _kill_group(child.pid)  # children that outlived the command
    if folder:
        shutil.rmtree(folder, ignore_errors=True)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))

"""A service of one's own: started beside this process, ended with it."""

import importlib.util
import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import weakref
from pathlib import Path
from typing import IO

from modallab_client.errors import ConflictError, MissingExtraError, ServiceStartError, UnreachableError
from modallab_client.settings import EMBEDDED

PACKAGES = ("modallab", "alembic", "dbos", "fastapi", "pydantic", "scipy", "sqlalchemy", "uvicorn")
GUARDIAN = Path(__file__).with_name("_guardian.py")


def require_service() -> None:
    """Return if the service's packages are installed; none of them is imported.

    Raises
    ------
    MissingExtraError
        If one is not; the message holds the command that installs them.
    """
    missing = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        raise MissingExtraError(
            "embedded() needs the service's packages beside the client: pip install 'modallab[service]'",
            context={"missing": ", ".join(missing)},
        )


def serve_command() -> list[str]:
    """Return the command that serves as its environment says."""
    return [sys.executable, "-m", "modallab", "serve"]


def serve_environment(port: int, data: Path, key: str) -> dict[str, str]:
    """Return the environment of a service of `data` on that loopback port that knows this program's key.

    Settings meant for another service on this machine, such as its database, are left out.
    """
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("MODALLAB_")}
    ours = {"MODALLAB_HOST": "127.0.0.1", "MODALLAB_PORT": str(port), "MODALLAB_DATA": str(data)}
    return inherited | ours | {"MODALLAB_EMBEDDING_KEY": key}


class ServiceProcess:
    """A service on a free loopback port, its data in a folder that no other embedded service may use.

    Without a folder it works in a temporary one, removed in the end. It ends with `stop`, with the
    interpreter, and also if this process is killed.
    """

    def __init__(self, data: str | Path | None = None) -> None:
        if os.name != "posix":
            raise ServiceStartError("embedded() needs Linux or macOS; elsewhere use ModalLab(url)")
        port = _free_port()
        temporary = tempfile.mkdtemp(prefix="modallab-") if data is None else ""
        folder = Path(temporary or data or "").resolve()
        folder.mkdir(parents=True, exist_ok=True)
        self.url = f"http://127.0.0.1:{port}"
        self.key = secrets.token_urlsafe(32)  # lets this program in where the folder has keys
        self._log = folder / "service.log"
        with _lock(folder) as lock, self._log.open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-P", str(GUARDIAN), temporary, *serve_command()],
                env=serve_environment(port, folder, self.key),
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C in a terminal is for the caller alone
                pass_fds=[lock.fileno()],
            )
        self._started = time.monotonic()
        self.stop = weakref.finalize(self, _stop, self._process, temporary)

    def check_start(self) -> None:
        """Return while the service may still be starting.

        Raises
        ------
        ServiceStartError
            If it has ended or takes too long; the end of its log is in the message.
        """
        code = self._process.poll()
        if code is not None:
            self._fail(f"the embedded service ended with code {code} while it started")
        if time.monotonic() - self._started > EMBEDDED.start_timeout:
            self._fail(f"the embedded service did not answer within {EMBEDDED.start_timeout:g} s")

    def check_running(self) -> None:
        """Return if the service's process lives.

        Raises
        ------
        UnreachableError
            If it has ended; the end of its log is in the message.
        """
        try:
            code = self._process.wait(EMBEDDED.exit_notice)
        except subprocess.TimeoutExpired:
            return
        raise UnreachableError(f"the embedded service has ended with code {code}.\n{self.log_tail()}")

    def log_tail(self) -> str:
        """Return the last lines the service wrote."""
        try:
            lines = self._log.read_text(errors="replace").splitlines()
        except OSError:
            return ""
        return "\n".join(lines[-EMBEDDED.log_lines :])

    def _fail(self, reason: str) -> None:
        tail = self.log_tail()
        self.stop()
        raise ServiceStartError(f"{reason}. Its log ends with:\n{tail or '(nothing)'}")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _lock(folder: Path) -> IO[bytes]:
    import fcntl  # not on every system that can use the rest of the client

    lock = (folder / ".embedded.lock").open("wb")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        raise ConflictError(
            "another embedded service works in this folder", context={"data": str(folder)}
        ) from None
    return lock


def _stop(process: "subprocess.Popen[bytes]", temporary: str) -> None:
    pipe = process.stdin
    if pipe is not None and not pipe.closed:
        try:
            pipe.write(b"\n")  # a forked copy of this process may hold the pipe open: say it as well
            pipe.close()
        except BrokenPipeError:
            pass  # the guardian has ended by itself
    try:
        process.wait(EMBEDDED.stop_timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if temporary:
        shutil.rmtree(temporary, ignore_errors=True)

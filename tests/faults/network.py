"""Hosts that share a database and a folder only: each has namespaces of its own, of network and processes."""

import os
import pwd
import secrets
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

SERVER = "198.18.77.1"  # of the range that is set apart for tests of networks, RFC 2544
HOSTS = {"one": "198.18.77.11", "two": "198.18.77.12"}
_NET = "198.18.77.0/24"
_PORT = 5432
_START = 30.0  # s for a database server to start, of which it needs one


def lacking() -> str | None:
    """Return what this machine lacks for networks of hosts; None: nothing."""
    if os.geteuid() != 0:
        return "only root may make network namespaces"
    for program in ("ip", "unshare"):
        if shutil.which(program) is None:
            return f"there is no program {program!r}"
    if _server_programs() is None:
        return "there are no programs of a PostgreSQL server"
    name = f"try-{secrets.token_hex(3)}"
    tried = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True)
    subprocess.run(["ip", "netns", "delete", name], capture_output=True)
    return None if tried.returncode == 0 else f"no network namespace can be made: {tried.stderr.strip()}"


def _server_programs() -> Path | None:
    """Return the folder of a database server's programs, which Debian keeps out of the path."""
    found = shutil.which("postgres")
    folders = [Path(found).parent] if found else []
    folders += sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    names = ("initdb", "postgres", "pg_isready")
    return next((folder for folder in folders if all((folder / name).exists() for name in names)), None)


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True, timeout=20)


@dataclass(frozen=True)
class Link:
    """Cable of a host to the switch that the database server is at."""

    namespace: str
    outer: str
    """Its end at the switch."""
    switch: str

    @property
    def within(self) -> tuple[str, ...]:
        """Beginning of the command line of a process of the host, whose processes no other host sees."""
        return ("ip", "netns", "exec", self.namespace, "unshare", "--pid", "--kill-child", "--mount-proc")

    @contextmanager
    def down(self) -> Iterator[None]:
        """Take the host's own end down: the host is told at once that it reaches nobody."""
        own = ("-netns", self.namespace, "link", "set", "eth0")
        _ip(*own, "down")
        try:
            yield
        finally:
            _ip(*own, "up")

    @contextmanager
    def lossy(self) -> Iterator[None]:
        """Lose every packet at the switch: neither side is told anything."""
        _ip("link", "set", self.outer, "nomaster")
        try:
            yield
        finally:
            _ip("link", "set", self.outer, "master", self.switch)


@contextmanager
def network() -> Iterator[dict[str, Link]]:
    """Yield the links of the hosts by their names; `SERVER` is this machine's own address at the switch."""
    word = secrets.token_hex(3)
    switch = f"sw{word}"
    with ExitStack() as stack:
        _ip("link", "add", switch, "type", "bridge")
        stack.callback(_ip, "link", "delete", switch)
        _ip("address", "add", f"{SERVER}/24", "dev", switch)
        _ip("link", "set", switch, "up")
        links = {}
        for number, (name, address) in enumerate(HOSTS.items()):
            link = Link(f"{name}-{word}", f"v{number}{word}", switch)
            _ip("netns", "add", link.namespace)
            stack.callback(_ip, "netns", "delete", link.namespace)
            _ip(
                *("link", "add", link.outer, "type", "veth"),
                *("peer", "name", "eth0", "netns", link.namespace),
            )
            _ip("link", "set", link.outer, "master", switch, "up")
            _ip("-netns", link.namespace, "address", "add", f"{address}/24", "dev", "eth0")
            for device in ("lo", "eth0"):
                _ip("-netns", link.namespace, "link", "set", device, "up")
            links[name] = link
        yield links


@contextmanager
def database_server() -> Iterator[str]:
    """Yield the URL of a PostgreSQL server of its own, which listens at the switch."""
    programs = _server_programs()
    assert programs is not None
    known = {entry.pw_name for entry in pwd.getpwall()}
    user = "postgres" if "postgres" in known else "nobody"  # the server refuses to run as root
    folder = Path(tempfile.mkdtemp(prefix="cluster"))
    shutil.chown(folder, user)
    data = folder / "data"
    try:
        made = [str(programs / "initdb"), "--auth=trust", "--username=postgres", "--no-sync", "-D", str(data)]
        subprocess.run(made, check=True, capture_output=True, user=user, cwd=folder, timeout=60)
        with (data / "pg_hba.conf").open("a") as rules:
            rules.write(f"host all all {_NET} trust\n")
        settings = {"listen_addresses": SERVER, "port": _PORT, "unix_socket_directories": "", "fsync": "off"}
        started = [str(programs / "postgres"), "-D", str(data)]
        started += [f"-c{name}={value}" for name, value in settings.items()]
        with (folder / "log").open("wb") as log:
            server = subprocess.Popen(started, user=user, cwd=folder, stdout=log, stderr=log)
        try:
            _wait_until_up(programs)
            yield f"postgresql://postgres@{SERVER}:{_PORT}/postgres"
        finally:
            server.send_signal(2)  # breaks all connections
            with suppress(subprocess.TimeoutExpired):
                server.wait(10)
            server.kill()
            server.wait()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _wait_until_up(programs: Path) -> None:
    end = time.monotonic() + _START
    asked = [str(programs / "pg_isready"), "-q", "-h", SERVER, "-p", str(_PORT)]
    while subprocess.run(asked).returncode != 0:
        if time.monotonic() > end:
            raise TimeoutError("the database server did not start")
        time.sleep(0.1)

"""A service, worker hosts and a database that a test disturbs, and jobs with known results."""

import signal
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import psutil
import sqlalchemy as sa

from modallab.api.settings import ServiceSettings
from modallab.store.engine import make_engine
from tests.databases import database
from tests.serving import Lab, free_port, running

LIMIT = 60.0  # s after the end of a fault within which every job has ended
# Other tests fill both cores, at a higher priority than any job has: an update of 5 s was at a fifth of its
# iterations after 60 s.
BESIDE_OTHERS = 240.0  # s, the limit in the suite
HARDLY = {"location_tolerance": 1e-12, "tolerance": 1e-12, "suspect_threshold": 0.0, "max_step": 1e-3}


SMALL_DISK = 256 * 2**20  # bytes


def may_mount() -> bool:
    """Return whether a small disk may be had here."""
    refused = OSError, subprocess.CalledProcessError
    with tempfile.TemporaryDirectory() as folder, suppress(*refused), small_disk(Path(folder)):
        return True
    return False


@contextmanager
def small_disk(folder: Path) -> Iterator[None]:
    """Keep a folder on a file system of its own that is soon full; needs root."""
    options = ("-t", "tmpfs", "-o", f"size={SMALL_DISK}", "tmpfs", str(folder))
    subprocess.run(["mount", *options], check=True, capture_output=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True, capture_output=True)


class Gate:
    """A way to the database that can be shut: connections break, and none is accepted."""

    def __init__(self, host: str, port: int) -> None:
        self._target, self._open, self._connections = (host, port), threading.Event(), set[socket.socket]()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._open.set()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                if not self._open.is_set():
                    client.close()
                    continue
                server = socket.create_connection(self._target)
                self._connections |= {client, server}
                for one, other in ((client, server), (server, client)):
                    threading.Thread(target=self._pass, args=(one, other), daemon=True).start()

    def _pass(self, one: socket.socket, other: socket.socket) -> None:
        with suppress(OSError):
            while data := one.recv(65536):
                other.sendall(data)
        with suppress(OSError):
            other.shutdown(socket.SHUT_RDWR)
        one.close()
        self._connections.discard(one)

    @contextmanager
    def shut(self) -> Iterator[None]:
        """Keep everybody from the database."""
        self._open.clear()
        for connection in list(self._connections):
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
        try:
            yield
        finally:
            self._open.set()

    def close(self) -> None:
        """Stop listening, and break all connections."""
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for connection in list(self._connections):
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)


@dataclass
class Site:
    """A service with what is around it."""

    lab: Lab
    settings: ServiceSettings
    """As the test reaches the database: not through the gate."""
    environment: dict[str, str]
    data: Path
    gate: Gate | None
    stack: ExitStack
    serving: tuple[str, ...]
    """Command line of the service."""
    hosts: list["subprocess.Popen[bytes]"] = field(default_factory=list)
    """Processes that run jobs, and their children."""

    def start_host(self) -> None:
        """Start one more process that runs jobs: a worker, or the service itself where it is embedded."""
        arguments = ("worker",) if self.gate else self.serving
        started = running(*arguments, data=self.data, environment=self.environment)
        self.hosts.append(self.stack.enter_context(started))
        if not self.gate:
            self.lab.wait_until_up()

    def children(self, hosts: Sequence["subprocess.Popen[bytes]"] | None = None) -> list[psutil.Process]:
        """Return the worker processes of some hosts, of all by default."""
        chosen = self.hosts if hosts is None else hosts
        living = [psutil.Process(host.pid) for host in chosen if host.poll() is None]
        return [child for host in living for child in host.children()]

    def hit(self, number: signal.Signals) -> None:
        """Send a signal to all worker processes."""
        for child in self.children():
            with suppress(psutil.NoSuchProcess):
                child.send_signal(number)

    def not_results(self) -> dict[str, int]:
        """Return the numbers of resources by kind that are not results of jobs, and of half-written files.

        Updated structures are left out: each update has one.
        """
        book = make_engine(self.settings.store_place.url, schema=self.settings.database_schema)
        results = "SELECT result_id FROM jobs WHERE state = 'succeeded' AND result_id IS NOT NULL"
        query = f"SELECT kind, count(*) FROM things WHERE id NOT IN ({results}) GROUP BY kind"
        updates = "SELECT count(*) FROM things WHERE kind = 'update'"
        with book.begin() as connection:
            counts = {kind: int(count) for kind, count in connection.execute(sa.text(query))}
            counts["structure"] -= int(connection.execute(sa.text(updates)).scalar_one())
        book.dispose()
        return counts | {"part": len(list((self.data / "arrays").rglob("*.part")))}

    def unfinished(self) -> tuple[int, int]:
        """Return how many jobs book and engine have still to do."""
        book = make_engine(self.settings.store_place.url, schema=self.settings.database_schema)
        place = self.settings.job_place
        jobs = make_engine(place.url, schema=place.schema)
        counts = []
        for engine, query in (
            (book, "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')"),
            (jobs, "SELECT count(*) FROM workflow_status WHERE status IN ('PENDING', 'ENQUEUED', 'DELAYED')"),
        ):
            with engine.begin() as connection:
                counts.append(int(connection.execute(sa.text(query)).scalar_one()))
            engine.dispose()
        return counts[0], counts[1]


@contextmanager
def site(kind: str, data: Path) -> Iterator[Site]:
    """Yield a service on SQLite, or one on PostgreSQL whose jobs two worker hosts run."""
    port = free_port()
    with ExitStack() as stack:
        lab = stack.enter_context(Lab(port))
        if kind == "sqlite":
            found = Site(
                lab, ServiceSettings(data=data), {}, data, None, stack, ("serve", "--port", str(port))
            )
            found.start_host()
            yield found
            return
        url, schema = stack.enter_context(database(kind, data))
        parsed = sa.make_url(url)
        gate = Gate(parsed.host or "127.0.0.1", parsed.port or 5432)
        stack.callback(gate.close)
        gated = parsed.set(host="127.0.0.1", port=gate.port).render_as_string(hide_password=False)
        environment = {"MODALLAB_DATABASE_URL": gated, "MODALLAB_DATABASE_SCHEMA": schema}
        with running("init", data=data, environment=environment) as init:
            assert init.wait(60) == 0
        serving = ("serve", "--role", "api", "--port", str(port))
        stack.enter_context(running(*serving, data=data, environment=environment))
        lab.wait_until_up()
        settings = ServiceSettings(data=data, database_url=url, database_schema=schema)
        found = Site(lab, settings, environment, data, gate, stack, serving)
        for _ in range(2):
            found.start_host()
        yield found


@dataclass(frozen=True)
class Question:
    """A job of some seconds."""

    path: str
    body: dict[str, Any]
    told: tuple[str, ...]
    """Fields of the result that do not differ from run to run."""

    def start(self, lab: Lab) -> str:
        """Start the job and return its id."""
        return str(lab.json("POST", self.path, self.body)["id"])

    def result(self, lab: Lab, job: str, limit: float = LIMIT) -> Any:
        """Return what the job found; it has to end within the limit."""
        ended = wait_for(lab, job, limit)
        assert ended["state"] == "succeeded", ended
        found = lab.json("GET", f"{self.path}/{ended['result_id']}")
        arrays = lab.request("GET", f"{self.path}/{ended['result_id']}/arrays") if not self.told else None
        return {name: found[name] for name in self.told} if arrays is None else arrays.content


def wait_for(lab: Lab, job: str, limit: float = LIMIT) -> Any:
    """Return a job as soon as it has ended; a service that is away meanwhile is asked again."""
    end, found = time.monotonic() + limit, None
    while time.monotonic() < end:
        with suppress(AssertionError, httpx.HTTPError):
            found = lab.json("GET", f"/jobs/{job}")
            if found["state"] not in ("queued", "running"):
                return found
        time.sleep(0.1)
    raise TimeoutError(f"{job} has not ended {limit:.0f} s after the fault: {found}")


def questions(lab: Lab) -> list[Question]:
    """Return a measurement, an extraction and an update, each of some seconds."""
    model = lab.json("POST", "/structures", {"kind": "catalogue", "name": "bay"})["id"]
    changes = [{"members": [1, 2], "property": "density", "factor": 1.5}]
    truth = lab.json("POST", f"/structures/{model}/changes", {"changes": changes})["id"]
    dofs = [f"{n}:+{d}" for n in range(1, 31) for d in "XY"]
    synthetic = {
        "count": 10,
        "dofs": dofs,
        "noise": {"eigenvalue": 0.05, "eigenvector": 0.1},
        "seed": 1,
    }
    modes = lab.json("POST", f"/structures/{truth}/synthetic-modes", synthetic)["id"]
    beam = lab.json("POST", "/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"]
    rig = lab.json(
        "POST",
        "/rigs",
        {
            "drive": "1:+Y",
            "responses": [f"{n}:+Y" for n in range(1, 22)],
            "accelerometers": {"mass": 0.01, "roving": True},
            "analyser": {"frequency_max": 800.0, "n_lines": 1601, "averages": 200},
            "noise": {"force": 1e-3, "response": 1e-3},
        },
    )["id"]
    measuring = Question(
        "/measurements", {"structure_id": beam, "rig_id": rig, "route": "sampled", "seed": 1}, ()
    )
    measured = wait_for(lab, measuring.start(lab))["result_id"]
    return [
        measuring,
        Question("/modal-models", {"measurement_id": measured, "method": "line_fit"}, ()),
        Question(
            "/updates",
            {
                "structure_id": model,
                "modal_model_id": modes,
                "options": HARDLY | {"max_iterations": 60},
            },
            ("coefficients", "frequencies", "stopped_because", "iterations"),
        ),
    ]

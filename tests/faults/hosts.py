"""Cuts a host off in the middle of a job, and tells what became of the job.

    python -m tests.faults.hosts --rounds 6

Two hosts, each with a service and a worker, share a database server and a folder and nothing else. In each
round the host of a measurement is cut off, in turn by a link that is down and by one that loses all packets;
the job has to end on the other host with the bytes of an undisturbed one. The host that was cut off has to
work again: then the other one is cut off, and the next job is the first one's. The folder stays within reach,
so that whatever the lost host still writes can do harm. Needs root.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import sqlalchemy as sa

from modallab.api.settings import ServiceSettings
from modallab.store.engine import make_engine
from tests.faults.network import HOSTS, Link, database_server, lacking, network
from tests.faults.site import LIMIT, Question
from tests.serving import Lab, running

_SCHEMA = "lab"
_API = 8000
TRIES = 3  # jobs of which one has to last until its host is cut off
Cut = Callable[[Link], AbstractContextManager[None]]
CUTS: dict[str, Cut] = {"link down": Link.down, "packets lost": Link.lossy}


@dataclass(frozen=True)
class Host:
    """A service and a worker behind a link."""

    name: str
    link: Link
    lab: Lab


@dataclass
class Pair:
    """Two hosts, and what they share."""

    hosts: list[Host]
    settings: ServiceSettings
    """As the database server's own machine reaches it."""
    asked: Question
    limit: float
    """s within which each job has to end."""
    jobs: int = 0
    """Measurements that were asked for."""

    def other(self, host: Host) -> Host:
        """Return the host that is not this one."""
        return next(each for each in self.hosts if each is not host)

    def start(self, lab: Lab) -> str:
        """Start a measurement and return the id of the job."""
        self.jobs += 1
        return self.asked.start(lab)

    def result(self, lab: Lab, job: str) -> object:
        """Return what a job finds, as a host tells it."""
        return self.asked.result(lab, job, self.limit)

    def undisturbed(self) -> object:
        """Return what the job finds."""
        return self.result(self.hosts[0].lab, self.start(self.hosts[0].lab))

    def runner(self, job: str) -> Host:
        """Return the host that has a job."""
        query = "SELECT executor_id FROM workflow_status WHERE workflow_uuid = :job"
        name = self._told(query, of_jobs=True, job=job)
        return next(host for host in self.hosts if host.name == name)

    def beat(self, host: Host) -> object:
        """Return the counter of a host's worker; None while it is taken for lost."""
        return self._told("SELECT beat FROM executors WHERE id = :name", name=host.name)

    def unfinished(self) -> tuple[object, object]:
        """Return how many jobs book and engine have still to do."""
        book = "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')"
        engine = "SELECT count(*) FROM workflow_status WHERE status IN ('PENDING', 'ENQUEUED', 'DELAYED')"
        return self._told(book), self._told(engine, of_jobs=True)

    def stored(self) -> tuple[object, int, int]:
        """Return how many measurements, files of them and half-written files there are."""
        files = list((self.settings.data / "arrays").glob("*/*"))
        half = sum(file.suffix == ".part" for file in files)
        rows = self._told("SELECT count(*) FROM things WHERE kind = 'measurement'")
        named = self._told("SELECT count(*) FROM things WHERE arrays_hash IS NOT NULL")
        assert isinstance(named, int)
        return rows, len(files) - half - named, half

    def _told(self, query: str, *, of_jobs: bool = False, **values: str) -> object:
        schema = self.settings.job_place.schema if of_jobs else self.settings.database_schema
        engine = make_engine(self.settings.store_place.url, schema=schema)
        try:
            with engine.begin() as connection:
                return connection.execute(sa.text(query), values).scalar()
        finally:
            engine.dispose()


def asked_of(lab: Lab) -> Question:
    """Return a measurement of some seconds."""
    beam = lab.json("POST", "/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"]
    rig = {
        "drive": "1:+Y",
        "responses": [f"{n}:+Y" for n in range(1, 22)],
        "accelerometers": {"mass": 0.01, "roving": True},
        "analyser": {"frequency_max": 800.0, "n_lines": 1601, "averages": 400},
        "noise": {"force": 1e-3, "response": 1e-3},
    }
    ids = {"structure_id": beam, "rig_id": lab.json("POST", "/rigs", rig)["id"]}
    return Question("/measurements", ids | {"route": "sampled", "seed": 1}, ())


@contextmanager
def pair(data: Path, limit: float = LIMIT) -> Iterator[Pair]:
    """Yield two hosts with a service and a worker each."""
    with ExitStack() as stack:
        links = stack.enter_context(network())
        url = stack.enter_context(database_server())
        environment = {"MODALLAB_DATABASE_URL": url, "MODALLAB_DATABASE_SCHEMA": _SCHEMA}
        with running("init", data=data, environment=environment) as init:
            assert init.wait(60) == 0
        hosts = []
        for name, link in links.items():
            address = ("--host", HOSTS[name], "--port", str(_API), "--open")
            for arguments in (("serve", "--role", "api", *address), ("worker", "--executor-id", name)):
                started = running(*arguments, data=data, environment=environment, within=link.within)
                stack.enter_context(started)
            lab = stack.enter_context(Lab(_API, host=HOSTS[name]))
            lab.wait_until_up()
            hosts.append(Host(name, link, lab))
        settings = ServiceSettings(data=data, database_url=url, database_schema=_SCHEMA)
        found = Pair(hosts, settings, asked_of(hosts[0].lab), limit)
        for host in hosts:
            until(partial(found.beat, host), "a worker starts", limit)
        yield found


def until(condition: Callable[[], object], what: str, limit: float) -> float:
    """Return the seconds until a condition holds."""
    begin = time.monotonic()
    while not condition():
        if time.monotonic() - begin > limit:
            raise TimeoutError(f"{what}: not within {limit:.0f} s")
        time.sleep(0.1)
    return time.monotonic() - begin


@dataclass(frozen=True)
class Outcome:
    """What became of a job whose host was cut off, and of the host."""

    runner: str
    found: object
    """Result of the job."""
    seconds: float
    """s from the cut to the end of the job."""
    back: float
    """s from the mended link to a sign of life of the host."""
    again: object
    """Result of a job that the host then did alone."""


def cut_off(place: Pair, cut: Cut, fraction: float) -> Outcome:
    """Cut off the host that runs a job when the job is so far; mend the link; have the host work alone."""
    for _ in range(TRIES):
        job = place.start(place.hosts[0].lab)
        place.hosts[0].lab.wait_for(job, state="running", fraction=fraction)
        lost = place.runner(job)
        left = place.other(lost)
        begin = time.monotonic()
        with cut(lost.link):
            if left.lab.json("GET", f"/jobs/{job}")["state"] == "succeeded":
                continue  # the machine was too busy to cut in time
            found = place.result(left.lab, job)
            seconds = time.monotonic() - begin
            if place.runner(job) is lost:
                continue  # its last words were under way already
        back = returned(place, lost)
        with cut(left.link):
            again = place.result(lost.lab, place.start(lost.lab))
        returned(place, left)
        until(lambda: place.unfinished() == (0, 0), "book and engine agree", place.limit)
        return Outcome(lost.name, found, seconds, back, again)
    raise TimeoutError(f"none of {TRIES} jobs lasted until its host was cut off")


def returned(place: Pair, host: Host) -> float:
    """Return the seconds until a host whose link was mended shows that it lives."""
    before = place.beat(host)
    return until(lambda: place.beat(host) not in (None, before), "the host is back", place.limit)


def main() -> None:
    """Cut hosts off and print what became of their jobs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if (reason := lacking()) is not None:
        raise SystemExit(f"cannot run here: {reason}")
    rng = np.random.default_rng(options.seed)
    with tempfile.TemporaryDirectory() as folder, pair(Path(folder)) as place:
        expected = place.undisturbed()
        for number in range(options.rounds):
            name, fraction = list(CUTS)[number % len(CUTS)], float(rng.uniform(0.05, 0.8))
            outcome = cut_off(place, CUTS[name], fraction)
            same = [result == expected for result in (outcome.found, outcome.again)]
            print(
                f"{name} at {fraction:.2f} on host {outcome.runner}: ended after {outcome.seconds:.1f} s, "
                f"same bytes {same}, back after {outcome.back:.1f} s",
                flush=True,
            )
        rows, needless, half = place.stored()
        print(f"{place.jobs} jobs, {rows} measurements, {needless} needless files, {half} half-written")


if __name__ == "__main__":
    main()

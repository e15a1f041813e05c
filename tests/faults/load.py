"""A class at work beside one user who has queued a hundred diagnoses: what the class notices of it.

    python -m tests.faults.load
    python -m tests.faults.load --students 30 --seconds 60 --think 10

The service and its jobs have core 0, the students core 1. The same class works once without that user first.
"""

import argparse
import asyncio
import os
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import AsyncExitStack, ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from statistics import median
from typing import Any

import httpx
import numpy as np
import psutil
import sqlalchemy as sa

from modallab.api.settings import ServiceSettings
from modallab.store.keys import KeyBook, Role
from modallab.store.place import engine_of
from modallab.store.tables import JOBS
from modallab_client import AsyncModalLab
from modallab_client.errors import ClientError
from tests.serving import Lab, free_port, running

LIMIT_WAIT, LIMIT_STATUS, LIMIT_GROWTH, LEAST_SHARE, LEAST_LOOPS = 5.0, 0.1, 1.05, 0.9, 0.5
RIG: dict[str, Any] = {
    "drive": "1:+Y",
    "responses": [f"{n}:+Y" for n in range(1, 22, 2)],
    "noise": {"force": 1e-3, "response": 1e-3},
}


@dataclass(frozen=True)
class Load:
    """A class, and the user beside it."""

    students: int
    seconds: float
    think: float
    """s, mean time before each of a student's three steps."""
    diagnoses: int
    """Diagnoses that the other user queues before the class begins."""


@dataclass
class Observation:
    """What was seen of a class at work."""

    loops: list[int]
    """Completed loops of every student: create, measure, extract."""
    errors: Counter[str] = field(default_factory=Counter)
    waits: list[float] = field(default_factory=list)
    """s, from the request of each student's job to its begin."""
    statuses: list[float] = field(default_factory=list)
    """s, until `GET /v1/jobs/{id}` was answered."""
    memory: list[tuple[float, int]] = field(default_factory=list)
    """s since the beginning, and B, of the service and its processes."""
    diagnosed: int = 0
    """Diagnoses of the other user that were done meanwhile."""

    def p(self, percent: float, times: list[float]) -> float:
        """Return a percentile of times, s; infinite if there are none."""
        return float(np.percentile(times, percent)) if times else np.inf

    @property
    def growth(self) -> float:
        """Ratio of the memory at the end to that after the first minute, medians of a minute each."""
        end = self.memory[-1][0]
        first = [used for at, used in self.memory if 60 <= at < 120]
        last = [used for at, used in self.memory if at >= end - 60]
        return median(last) / median(first) if first else 1.0

    def faults(self) -> list[str]:
        """Return what a class should not have to notice."""
        found = [f"{n} x {name}" for name, n in self.errors.items()]
        if self.p(95, self.waits) >= LIMIT_WAIT:
            found.append(f"a short job waits {self.p(95, self.waits):.2f} s (p95)")
        if min(self.loops) < LEAST_LOOPS * median(self.loops):
            found.append(f"a student completed {min(self.loops)} loops, the median is {median(self.loops):g}")
        if self.p(99, self.statuses) >= LIMIT_STATUS:
            found.append(f"the state of a job takes {1e3 * self.p(99, self.statuses):.0f} ms (p99)")
        if self.growth > LIMIT_GROWTH:
            found.append(f"memory grows by a factor of {self.growth:.3f}")
        return found


@contextmanager
def on_core(core: int) -> Iterator[None]:
    """Keep this process, and those that it starts meanwhile, on a core, where there is one of that number."""
    before = os.sched_getaffinity(0)
    with suppress(OSError):
        os.sched_setaffinity(0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


async def student(lab: AsyncModalLab, seen: Observation, i: int, load: Load, until: float) -> None:
    """Create a structure and a rig, measure, extract, again and again, with time to think between."""
    rng = np.random.default_rng([load.students, i])

    async def think() -> bool:
        """Return whether the class goes on after a time to think."""
        # With exponential times some student of a hundred completes 2 loops of 5 however fast the service is.
        seconds, left = float(rng.uniform(0.5, 1.5)) * load.think, until - time.monotonic()
        await asyncio.sleep(max(0.0, min(seconds, left)))
        return seconds < left

    while await think():
        try:
            beam = await lab.structures.catalogue("chapter-5-beam")
            rig = await lab.rigs.create(**RIG)
            if not await think():
                return  # nobody starts a job at the bell: all would at once
            test = await (await lab.measurements.start(beam, rig, seed=i)).result()
            if not await think():
                return
            await (await lab.modal_models.start(test, method="dobson", n_modes=8)).result()
            seen.loops[i] += 1
        except (ClientError, httpx.HTTPError) as error:
            seen.errors[f"{type(error).__name__}: {error}"[:200]] += 1


async def queue_diagnoses(lab: AsyncModalLab, n: int) -> None:
    """Have all processes started, and queue diagnoses of a test with an effect that the model lacks."""
    beam = await lab.structures.catalogue("chapter-5-beam")
    truth = await lab.structures.change(beam, members=[7], property="modulus", factor=1.3)
    rig = await lab.rigs.create(**RIG)
    tests = [await lab.measurements.start(truth, rig, seed=1) for _ in range(2)]
    test, _ = await asyncio.gather(*(job.result() for job in tests))
    for seed in range(n):
        await lab.diagnoses.start(beam, test, seed=seed)


async def probe(url: str, key: str, job: str, service: int, seen: Observation, until: float) -> None:
    """Ask for the state of a job, and look at the memory, several times a second."""
    begin, process = time.monotonic(), psutil.Process(service)
    async with httpx.AsyncClient(base_url=url, headers={"Authorization": f"Bearer {key}"}) as http:
        while (now := time.monotonic()) < until:
            (await http.get(f"/v1/jobs/{job}", timeout=60)).raise_for_status()
            seen.statuses.append(time.monotonic() - now)
            with suppress(psutil.NoSuchProcess):
                tree = [process, *process.children(recursive=True)]
                seen.memory.append((now - begin, sum(one.memory_info().rss for one in tree)))
            await asyncio.sleep(0.2)


async def work(url: str, keys: list[str], load: Load, service: int) -> Observation:
    """Return what is seen of a class that works beside the first key's user."""
    seen = Observation([0] * load.students)
    async with AsyncModalLab(url, api_key=keys[0]) as other, AsyncExitStack() as stack:
        await queue_diagnoses(other, load.diagnoses)
        job = (await other.jobs.list())[0].id
        until = time.monotonic() + load.seconds
        labs = [await stack.enter_async_context(AsyncModalLab(url, api_key=key)) for key in keys[1:]]
        tasks = [student(lab, seen, i, load, until) for i, lab in enumerate(labs)]
        await asyncio.gather(probe(url, keys[0], job, service, seen, until), *tasks)
        seen.diagnosed = len(await other.jobs.list(state="succeeded", kind="diagnosis"))
    return seen


def observe(load: Load, data: Path) -> Observation:
    """Return what is seen of a class at a service in an empty folder."""
    settings, port = ServiceSettings(data=data), free_port()
    settings.store_place.prepare()
    book = KeyBook(engine_of(settings.store_place))
    book.create("admin", Role.ADMIN)
    students = book.create_several([f"student {i}" for i in range(1 + load.students)], Role.STUDENT)
    with ExitStack() as stack:
        with on_core(0):
            service = stack.enter_context(running("serve", "--port", str(port), data=data))
        lab = stack.enter_context(Lab(port))
        stack.enter_context(on_core(1))
        lab.wait_until_up()
        url = f"http://127.0.0.1:{port}"
        seen = asyncio.run(work(url, [new.text for new in students], load, service.pid))
    seen.waits = waits(engine_of(settings.store_place), students[0].key.id)
    engine_of(settings.store_place).dispose()
    return seen


def waits(engine: sa.Engine, other: str) -> list[float]:
    """Return the times, s, that the jobs of all but one owner waited."""
    query = sa.select(JOBS.c.created, JOBS.c.started).where(
        JOBS.c.owner != other, JOBS.c.started.is_not(None)
    )
    with engine.begin() as connection:
        moments = [tuple(map(datetime.fromisoformat, row)) for row in connection.execute(query)]
    return [(started - created).total_seconds() for created, started in moments]


def main() -> None:
    """Print what a class notices, without the other user and beside him."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--students", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--think", type=float, default=20.0)
    parser.add_argument("--diagnoses", type=int, default=100)
    options = parser.parse_args()
    alone = 0
    for diagnoses in (0, options.diagnoses):
        load = Load(options.students, options.seconds, options.think, diagnoses)
        with tempfile.TemporaryDirectory() as folder:
            seen = observe(load, Path(folder))
        total, faults = sum(seen.loops), seen.faults()
        if diagnoses and total < LEAST_SHARE * alone:
            faults.append(f"{total} loops beside the other user, {alone} without")
        alone = total
        tell(seen, f"beside {diagnoses} diagnoses, of which {seen.diagnosed} were done")
        print(f"  faults: {faults or 'none'}", flush=True)


def tell(seen: Observation, title: str) -> None:
    """Print what was seen."""
    print(f"{title}: {sum(seen.loops)} loops, {min(seen.loops)} to {max(seen.loops)} a student")
    for name, times in (("wait of a job", seen.waits), ("GET /v1/jobs/{id}", seen.statuses)):
        told = ", ".join(f"p{percent} {seen.p(percent, times):.3f} s" for percent in (50, 95, 99))
        print(f"  {name}: {told} of {len(times)}")
    print(f"  memory {seen.memory[-1][1] / 1e6:.0f} MB, since the first minute x {seen.growth:.3f}")
    print(f"  load of the machine {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()

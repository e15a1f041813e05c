"""A durable runner in given places, and jobs for it."""

import gc
import time
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

import anyio
import numpy as np
from anyio import to_thread

from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.jobs.book import JobBook
from modallab.jobs.durable import DurableRunner, JobPlace
from modallab.jobs.retention import Retention
from modallab.jobs.runner import Job
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.plain import to_plain
from modallab.store.viewer import Viewer, Visibility
from modallab.updating.options import TwoStageOptions, UpdateOptions
from modallab.updating.parameterisation import parameterise
from modallab.updating.partitioning import automatic_groups

ME = Viewer("me", Visibility.OWN)
Places = tuple[StorePlace, JobPlace]
Work = Callable[[DurableRunner], Awaitable[None]]
# What noise pulls far is a thousand small steps away: such an update runs to its last iteration.
ENDLESS = TwoStageOptions(
    max_iterations=1000, location_tolerance=1e-12, tolerance=1e-12, suspect_threshold=0.0, max_step=1e-3
)

LONGEST_STANDSTILL = 60.0  # s; a share of the studies here takes 1 s, on a machine of one's own


def book_at(places: Places) -> JobBook:
    return JobBook(engine_of(places[0]), queue_length=10)


def arguments(places: Places, options: UpdateOptions) -> dict[str, Any]:
    """Return the arguments of an update in these places."""
    store, bay = open_store(places[0]), STRUCTURES["bay"]()
    noise, rng = ModeNoise(eigenvalue=0.05, eigenvector=0.1), np.random.default_rng(0)
    modes = synthetic_modes(assemble(bay), 10, bay.dofs, noise=noise, rng=rng)
    return {
        "structure_id": store.structures.add(bay, owner="me"),
        "modal_model_id": store.modal_models.add(modes, owner="me"),
        "method": "inverse_eigensensitivity",
        "parameterisation": to_plain(parameterise(automatic_groups(bay)))[0],
        "options": to_plain(options)[0],
    }


def run(places: Places, work: Work, retention: Retention | None = None) -> None:
    """Do some work with a runner in these places."""

    async def main() -> None:
        async with DurableRunner(book_at(places), *places, executor_id="test", retention=retention) as runner:
            await work(runner)

    anyio.run(main)
    gc.collect()  # here, where the warning below is expected, and not in whichever test comes next


async def until(runner: DurableRunner, job: Job, reached: Callable[[Job], bool]) -> Job:
    """Return a job as soon as it is where it should be; one that goes on, however slowly, is not late."""
    end, fraction = time.monotonic() + LONGEST_STANDSTILL, job.fraction
    while time.monotonic() < end:
        found = await to_thread.run_sync(partial(runner.get, job.id, viewer=ME))
        if reached(found):
            return found
        if found.fraction != fraction:
            end, fraction = time.monotonic() + LONGEST_STANDSTILL, found.fraction
        await anyio.sleep(0.05)
    raise TimeoutError(str(found))

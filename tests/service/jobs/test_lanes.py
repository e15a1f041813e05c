"""The durable runner keeps the order of the queue, in both lanes."""

from functools import partial
from typing import Any

import pytest
from anyio import to_thread

from modallab.jobs.durable import DurableRunner
from modallab.jobs.runner import Job, JobState, Lane
from modallab.updating.options import UpdateOptions
from tests.service.jobs.lasting import ENDLESS, ME, Places, arguments, book_at, run, until

pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <function BaseConnection.__del__:pytest.PytestUnraisableExceptionWarning"
)


async def submitted(runner: DurableRunner, given: dict[str, Any], owner: str, lane: Lane) -> Job:
    submit = partial(runner.submit, "update_and_store", given, owner=owner, lane=lane)
    return await to_thread.run_sync(submit)


def is_final(job: Job) -> bool:
    return job.state.final


def test_a_short_job_is_done_while_a_long_one_goes_on(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        endless, brief = arguments(places, ENDLESS), arguments(places, UpdateOptions(max_iterations=2))
        long = [await submitted(runner, endless, "me", Lane.LONG) for _ in range(3)]
        await until(runner, long[0], lambda job: job.fraction > 0)
        short = await submitted(runner, brief, "me", Lane.SHORT)
        assert (short.place, short.lane) == (1, Lane.SHORT)
        assert (await until(runner, short, is_final)).state is JobState.SUCCEEDED
        states = [runner.get(job.id, viewer=ME).state for job in long]
        assert states == [JobState.RUNNING, JobState.QUEUED, JobState.QUEUED]

    run(places, work)


def test_owners_take_turns_at_the_workers(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    brief = arguments(places, UpdateOptions(max_iterations=2))
    names: dict[str, str] = {}
    book = book_at(places)

    async def work(runner: DurableRunner) -> None:
        first = await submitted(runner, arguments(places, ENDLESS), "me", Lane.LONG)
        await until(runner, first, lambda job: job.fraction > 0)
        waiting = [await submitted(runner, brief, "me", Lane.LONG) for _ in range(3)]
        others = [await submitted(runner, brief, owner, Lane.LONG) for owner in ("ann", "bea")]
        names.update({job.id: job.owner for job in (*waiting, *others)})
        told = sorted(names, key=lambda job_id: book.get(job_id).place or 0)
        await to_thread.run_sync(partial(runner.cancel, first.id, viewer=ME))
        await until(runner, waiting[-1], is_final)
        began = sorted(names, key=lambda job_id: book.get(job_id).started or "")
        assert began == told
        assert [names[job_id] for job_id in began] == ["ann", "bea", "me", "me", "me"]

    run(places, work)

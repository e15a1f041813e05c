"""The durable runner: what a crash leaves between the book and the engine is mended."""

import gc
import os
import signal
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import anyio
import pytest
import sqlalchemy as sa
from anyio import to_process, to_thread
from anyio.abc import Process

from modallab.core.errors import NotFoundError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.jobs.dbos_engine import DbosEngine
from modallab.jobs.durable import DurableRunner
from modallab.jobs.executors import ExecutorBook, ExecutorTakenError
from modallab.jobs.processes import WorkerProcesses
from modallab.jobs.runner import Job, JobState
from modallab.jobs.settings import JOB
from modallab.jobs.studying import StudyInputs
from modallab.jobs.tasks import STUDY
from modallab.store.place import engine_of, open_store
from modallab.store.viewer import Viewer, Visibility
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import parameterise
from modallab.updating.studies.plan import NOISE_LEVELS, Division, Level, StudyPlan
from tests.service.jobs.lasting import ENDLESS, ME, Places, arguments, book_at, run, until

# A thread of the engine may hand its PostgreSQL connection back when the pool is gone already.
pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <function BaseConnection.__del__:pytest.PytestUnraisableExceptionWarning"
)


def test_a_job_runs_in_another_process_and_its_result_is_stored(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        assert job.state is JobState.QUEUED
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended
        assert open_store(places[0]).updates.holds(ended.result_id)
        with pytest.raises(NotFoundError):
            runner.get(job.id, viewer=Viewer("you", Visibility.OWN))

    run(places, work)


def test_a_cancelled_job_stops_within_a_second_and_stores_nothing(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        given = arguments(places, ENDLESS)
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        await until(runner, job, lambda j: j.fraction > 0)
        cancelled = await to_thread.run_sync(partial(runner.cancel, job.id, viewer=ME))
        assert cancelled.state is JobState.CANCELLED
        await anyio.sleep(1.0)
        seen = cancelled.fraction
        assert runner.get(job.id, viewer=ME).fraction == seen
        assert runner.cancel(job.id, viewer=ME).state is JobState.CANCELLED
        assert not open_store(places[0]).updates.holds(job.result_id)

    run(places, work)


def test_a_runner_that_ends_while_a_worker_process_starts_leaves_none_behind(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    processes: list[Process] = []

    async def opened(command: Sequence[str], **options: Any) -> Process:
        processes.append(await anyio.open_process(command, **options))
        return processes[-1]

    monkeypatch.setattr(to_process, "open_process", opened)

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, ENDLESS)
        await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        while not processes:
            await anyio.sleep(0.001)

    run(places, work)
    (process,) = processes
    # asyncio tells 255 of a child that another waiter of this process has reaped
    assert process.returncode in (-signal.SIGKILL, 255)
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)


def studying(places: Places, seeds: int, options: UpdateOptions) -> dict[str, Any]:
    """Return the arguments of a study in these places, a run for every seed."""
    store, beam = open_store(places[0]), STRUCTURES["chapter-5-beam"]()
    truth = change(beam, [MemberChange((11,), MemberProperty.MODULUS, factor=1.5)])
    plan = StudyPlan(
        "inverse_eigensensitivity",
        (Level("NL3", NOISE_LEVELS["NL3"]),),
        (Division("each", parameterise([[n] for n in range(1, 21)], ["stiffness"])),),
        tuple(range(seeds)),
        5,
        beam.dofs,
        options,
    )
    ids = [store.structures.add(structure, owner="me") for structure in (beam, truth)]
    return STUDY.arguments(StudyInputs(*ids), plan)


def test_the_runs_of_a_study_are_jobs_of_all_workers_and_its_progress_counts_them(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        given = studying(places, 4, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "study_and_store", given, owner="me"))
        told: list[str] = []

        def final(seen: Job) -> bool:
            told.append(seen.message)
            return seen.state.final

        ended = await until(runner, job, final)
        assert ended.state is JobState.SUCCEEDED, ended
        assert ended.message == "finished"
        assert any(message.endswith(" of 4 runs") for message in told)
        assert len(open_store(places[0]).studies.get(ended.result_id).runs) == 4
        assert runner._client is not None
        made = await to_thread.run_sync(partial(runner._client.list_workflows, name="share"))
        assert len(made) == 4

    run(places, work)


def test_a_cancelled_study_stops_with_all_its_runs_within_two_seconds(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        given = studying(places, 20, ENDLESS)
        job = await to_thread.run_sync(partial(runner.submit, "study_and_store", given, owner="me"))
        await until(runner, job, lambda j: j.state is JobState.RUNNING)
        cancelled = await to_thread.run_sync(partial(runner.cancel, job.id, viewer=ME))
        assert cancelled.state is JobState.CANCELLED
        await anyio.sleep(2.0)
        assert runner._client is not None
        left = await to_thread.run_sync(
            partial(runner._client.list_workflows, status=["PENDING", "ENQUEUED"])
        )
        assert not left
        assert not open_store(places[0]).studies.holds(job.result_id)
        # the worker is free for whoever comes next
        given = arguments(places, UpdateOptions(max_iterations=2))
        other = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        ended = await until(runner, other, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)


def test_a_study_that_a_restart_interrupts_keeps_the_runs_that_were_made(places: Places) -> None:
    jobs: list[Job] = []

    async def begin(runner: DurableRunner) -> None:
        given = studying(places, 12, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "study_and_store", given, owner="me"))
        jobs.append(await until(runner, job, lambda j: j.fraction > 0))

    async def go_on(runner: DurableRunner) -> None:
        ended = await until(runner, jobs[0], lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended
        study = open_store(places[0]).studies.get(ended.result_id)
        assert [run.seed for run in study.runs] == list(range(12))
        assert all(run.succeeded for run in study.runs)
        assert runner._client is not None
        made = await to_thread.run_sync(partial(runner._client.list_workflows, name="share"))
        assert len(made) == 12  # none was shared out anew

    run(places, begin)
    assert 0 < jobs[0].fraction < 1
    run(places, go_on)


def test_a_job_in_the_book_that_was_never_queued_is_queued_at_the_next_start(places: Places) -> None:
    given = arguments(places, UpdateOptions(max_iterations=2))
    job = book_at(places).open("update_and_store", given, owner="me")

    async def work(runner: DurableRunner) -> None:
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)


def test_a_job_that_the_engine_ended_behind_the_book_is_done_all_the_same(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        assert runner._client is not None
        await to_thread.run_sync(runner._client.cancel_workflow, job.id)
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)


def test_a_job_is_done_anew_after_an_error_that_nobody_foresaw(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The engine has to be able to write the error down: without an entry it takes the job for running."""
    run_in_process, errors = WorkerProcesses.run, [ProcessLookupError(3, "No such process")]

    async def failing(self: WorkerProcesses, *given: Any, **options: Any) -> Any:
        if errors:
            raise errors.pop()
        return await run_in_process(self, *given, **options)

    monkeypatch.setattr(WorkerProcesses, "run", failing)

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)


def test_a_job_that_is_ended_again_and_again_fails(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modallab.jobs.reconciler.JOB", replace(JOB, max_restarts=0))

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, ENDLESS)
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        await until(runner, job, lambda j: j.fraction > 0)
        assert runner._client is not None
        await to_thread.run_sync(runner._client.cancel_workflow, job.id)
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.FAILED
        assert ended.error is not None
        assert ended.error["code"] == "internal"

    run(places, work)


def test_an_executor_that_ends_leaves_the_others(places: Places) -> None:
    async def work(runner: DurableRunner) -> None:
        (executor,) = ExecutorBook(engine_of(places[0])).all()
        assert (executor.id, executor.pid) == ("test", os.getpid())
        assert runner.is_served()

    run(places, work)
    assert ExecutorBook(engine_of(places[0])).all() == []


def test_a_job_that_takes_too_long_fails_and_says_so(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modallab.jobs.durable.JOB", replace(JOB, time_limit=3.0))

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, ENDLESS)
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.FAILED
        assert ended.error is not None
        assert ended.error["code"] == "time_limit"
        assert "hours" in ended.message

    run(places, work)


def test_a_share_that_takes_too_long_does_not_hold_its_study(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("modallab.jobs.durable.JOB", replace(JOB, time_limit=3.0))

    async def work(runner: DurableRunner) -> None:
        given = studying(places, 1, ENDLESS)
        job = await to_thread.run_sync(partial(runner.submit, "study_and_store", given, owner="me"))
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state in (JobState.FAILED, JobState.SUCCEEDED)

    run(places, work)


def test_a_second_executor_of_a_name_is_refused(places: Places) -> None:
    async def main() -> None:
        first = DurableRunner(book_at(places), *places, executor_id="test")
        async with first:
            with pytest.raises(ExecutorTakenError, match="another name"):
                async with DurableRunner(book_at(places), *places, executor_id="test"):
                    pass

    anyio.run(main)
    gc.collect()


def test_a_job_whose_entry_the_engine_misses_is_queued_by_the_reconciler(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_: object) -> None:
        raise sa.exc.InterfaceError("INSERT", {}, Exception("the database is away"))

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        with monkeypatch.context() as patch:
            patch.setattr(DbosEngine, "enqueue", away)
            job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)


def test_a_job_that_was_taken_from_the_queue_and_never_started_is_done_all_the_same(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The database went away between the two: for the engine this executor had it under way for good."""
    tried: list[str] = []

    def away(_dbos: object, status: Mapping[str, str], *_: object) -> None:
        tried.append(status["workflow_uuid"])
        raise sa.exc.InterfaceError("SELECT", {}, Exception("the database is away"))

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        with monkeypatch.context() as patch:
            patch.setattr("dbos._queue.execute_dequeued_workflow", away)
            job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
            with anyio.fail_after(30.0):
                while job.id not in tried:
                    await anyio.sleep(0.05)
        ended = await until(runner, job, lambda j: j.state.final)
        assert ended.state is JobState.SUCCEEDED, ended

    run(places, work)

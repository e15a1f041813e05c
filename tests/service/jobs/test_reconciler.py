"""The reconciler: what book, engine and executors disagree on, and what is done about it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import psutil
import pytest

from modallab.jobs.book import JobBook
from modallab.jobs.executors import Executor, ExecutorBook
from modallab.jobs.postponed import DueJob, Postponed
from modallab.jobs.reconciler import Reconciler, end_stopped_children
from modallab.jobs.runner import Job, JobState
from modallab.jobs.settings import JOB
from modallab.store.place import StorePlace, engine_of

MINE = Executor.here("mine")
OTHER = Executor("other", "holder", "another machine", 1)


@dataclass
class Engine:
    """An engine of jobs that writes down what it is asked to do."""

    known: dict[str, bool] = field(default_factory=dict)
    running_on: set[str] = field(default_factory=set)
    left: set[str] = field(default_factory=set)
    asked: list[tuple[str, str]] = field(default_factory=list)

    def states(self, job_ids: Sequence[str]) -> dict[str, bool]:
        return {job_id: self.known[job_id] for job_id in job_ids if job_id in self.known}

    def unfinished(self) -> set[str]:
        return {job_id for job_id, unfinished in self.known.items() if unfinished}

    def owners(self) -> set[str]:
        return self.running_on

    def enqueue(self, job: Job) -> None:
        self.asked.append(("enqueue", job.id))

    def restart(self, job: Job) -> None:
        self.asked.append(("restart", job.id))

    def stop(self, job_id: str) -> None:
        self.asked.append(("stop", job_id))

    def forget(self, job_ids: Sequence[str]) -> None:
        self.asked += [("forget", job_id) for job_id in job_ids]

    def abandoned(self, executor_id: str) -> set[str]:
        return self.left

    def requeue(self, workflow_id: str, executor_id: str) -> None:
        self.asked.append(("requeue", workflow_id))

    def recover(self, executor_ids: Sequence[str]) -> None:
        self.asked += [("recover", executor_id) for executor_id in executor_ids]


@pytest.fixture
def executors(place: StorePlace) -> ExecutorBook:
    """The executors, this process among them."""
    executors = ExecutorBook(engine_of(place))
    executors.enter(MINE)
    return executors


def reconciler(executors: ExecutorBook, book: JobBook, engine: Engine) -> Reconciler:
    return Reconciler(MINE, executors, book, engine)


def test_a_job_that_the_engine_does_not_know_is_queued_at_the_second_look(
    executors: ExecutorBook, book: JobBook
) -> None:
    job, engine = book.open("update_and_store", {}, owner="me"), Engine()
    reconciles = reconciler(executors, book, engine)
    reconciles.mend()
    assert engine.asked == []  # whoever submits it may be between the two entries
    reconciles.mend()
    assert engine.asked == [("enqueue", job.id)]


def test_a_job_that_has_ended_for_the_engine_alone_is_restarted_a_few_times(
    executors: ExecutorBook, book: JobBook
) -> None:
    job, engine = book.open("update_and_store", {}, owner="me"), Engine()
    engine.known[job.id] = False
    reconciles = reconciler(executors, book, engine)
    for _ in range(JOB.max_restarts + 3):
        reconciles.mend()
    assert engine.asked == [("restart", job.id)] * JOB.max_restarts
    ended = book.get(job.id)
    assert ended.state is JobState.FAILED
    assert ended.error is not None
    assert ended.error["code"] == "internal"


def test_a_job_that_has_ended_for_the_book_alone_is_stopped(executors: ExecutorBook, book: JobBook) -> None:
    job, engine = book.open("update_and_store", {}, owner="me"), Engine()
    engine.known[job.id] = True
    book.cancel(job.id)
    reconciles = reconciler(executors, book, engine)
    reconciles.mend()
    reconciles.mend()
    assert engine.asked == [("stop", job.id)]


def test_jobs_that_both_have_under_way_are_left_alone(executors: ExecutorBook, book: JobBook) -> None:
    job, engine = book.open("update_and_store", {}, owner="me"), Engine(running_on={"mine"})
    engine.known[job.id] = True
    reconciles = reconciler(executors, book, engine)
    for _ in range(3):
        reconciles.mend()
    assert engine.asked == []


def test_what_this_executor_took_and_does_not_work_on_is_queued_anew_at_the_second_look(
    executors: ExecutorBook, book: JobBook
) -> None:
    job = book.open("update_and_store", {}, owner="me")
    engine = Engine(known={job.id: True}, running_on={"mine"}, left={job.id, "share of another"})
    reconciles = reconciler(executors, book, engine)
    reconciles.mend()
    assert engine.asked == []  # it may be between taking and starting them
    reconciles.mend()
    assert sorted(engine.asked) == sorted([("requeue", job.id), ("requeue", "share of another")])


def test_what_a_lost_executor_left_is_queued_anew_and_the_executor_removed(
    executors: ExecutorBook, book: JobBook
) -> None:
    executors.enter(OTHER)
    engine = Engine(running_on={"mine", "other"})
    reconciles = reconciler(executors, book, engine)
    now = 0.0
    reconciles._watch.clock = lambda: now
    while now <= JOB.lost_after:
        reconciles.mend()
        assert engine.asked == []
        now += JOB.beat_interval
    reconciles.mend()
    assert engine.asked == [("recover", "other")]
    assert executors.all() == [MINE]


def test_what_an_executor_nobody_knows_left_is_queued_anew(executors: ExecutorBook, book: JobBook) -> None:
    engine = Engine(running_on={"local"})  # as before executors were entered
    reconciler(executors, book, engine).mend()
    assert engine.asked == [("recover", "local")]


def test_a_job_whose_work_is_done_is_left_alone_until_its_time_has_come(
    executors: ExecutorBook, book: JobBook
) -> None:
    job, engine = book.open("update_and_store", {}, owner="me"), Engine()
    ended: list[DueJob] = []
    engine.known[job.id] = False
    book.start(job.id)
    book.postpone(job.id, Postponed(least=5.0, step=5.0), None)
    reconciles = Reconciler(MINE, executors, book, engine, end=ended.append)
    now = 0.0
    reconciles._timer.clock = lambda: now
    for _ in range(3):
        reconciles.mend()
    assert (engine.asked, ended) == ([], [])
    now = 5.0
    reconciles.mend()
    assert [due.id for due in ended] == [job.id]
    assert engine.asked == []


def test_a_job_that_cannot_be_ended_fails_and_others_end(executors: ExecutorBook, book: JobBook) -> None:
    ids = [book.open("update_and_store", {}, owner="me").id for _ in range(2)]
    for id in ids:
        book.start(id)
        book.postpone(id, Postponed(least=0.0, step=0.0), None)

    def end(job: DueJob) -> None:
        if job.id == ids[0]:
            raise ZeroDivisionError
        book.end_due(job.id)

    Reconciler(MINE, executors, book, Engine(), end=end).mend()
    assert [book.get(id).state for id in ids] == [JobState.FAILED, JobState.SUCCEEDED]
    assert book.due() == []


@dataclass
class Child:
    """A worker process."""

    state: str
    pid: int = 1
    killed: bool = False

    def status(self) -> str:
        return self.state

    def kill(self) -> None:
        self.killed = True


def test_a_stopped_child_is_killed_and_others_are_not(monkeypatch: pytest.MonkeyPatch) -> None:
    stopped, working = Child(psutil.STATUS_STOPPED), Child(psutil.STATUS_RUNNING)

    class Parent:
        def children(self) -> list[Child]:
            return [stopped, working]

    monkeypatch.setattr(psutil, "Process", Parent)
    end_stopped_children()
    assert (stopped.killed, working.killed) == (True, False)

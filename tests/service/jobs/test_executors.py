"""Executors: whether they live is told by counters and processes, not by clocks."""

import os
import platform
import subprocess
import sys
from dataclasses import replace

import pytest

from modallab.jobs.executors import Executor, ExecutorBook, ExecutorTakenError, Watch
from modallab.jobs.settings import JOB
from modallab.store.place import StorePlace, engine_of

ELSEWHERE = Executor("other", "holder", "another machine", 1)


class Clock:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def executors(place: StorePlace) -> ExecutorBook:
    """The executors of an empty database."""
    return ExecutorBook(engine_of(place))


def ended_process() -> int:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_an_executor_is_lost_when_its_counter_stands_still() -> None:
    clock = Clock()
    watch = Watch(clock)
    living = ELSEWHERE
    for beat in range(20):
        living = replace(ELSEWHERE, beat=beat)
        assert watch.lost([living]) == []
        clock.now += JOB.beat_interval
    since = clock.now - JOB.beat_interval
    while clock.now <= since + JOB.lost_after:
        assert watch.lost([living]) == []
        clock.now += JOB.beat_interval
    assert watch.lost([living]) == [living]


def test_nobody_is_lost_by_an_outage_in_which_nobody_could_beat() -> None:
    clock = Clock()
    watch = Watch(clock)
    assert watch.lost([ELSEWHERE]) == []
    clock.now += 120.0  # the database was away
    assert watch.lost([ELSEWHERE]) == []
    clock.now += JOB.beat_interval
    assert watch.lost([replace(ELSEWHERE, beat=1)]) == []


def test_an_executor_whose_process_has_ended_here_is_lost_at_once() -> None:
    gone = replace(Executor.here("gone"), pid=ended_process())
    assert Watch().lost([gone]) == [gone]
    assert Watch().lost([Executor.here("mine")]) == []


def test_a_name_of_a_process_that_has_ended_is_free(executors: ExecutorBook) -> None:
    executors.enter(replace(Executor.here("name"), pid=ended_process()))
    mine = Executor.here("name")
    executors.enter(mine)
    assert executors.all() == [mine]


def test_a_name_is_free_when_its_counter_stands_still(executors: ExecutorBook) -> None:
    executors.enter(ELSEWHERE)
    clock = Clock()
    watch = Watch(clock)
    assert watch.lost(executors.all()) == []
    for _ in range(int(JOB.lost_after / JOB.beat_interval) + 2):
        clock.now += JOB.beat_interval
        lost = watch.lost(executors.all())
    assert lost == [ELSEWHERE]


def test_a_name_whose_counter_rises_is_taken(executors: ExecutorBook) -> None:
    executors.enter(ELSEWHERE)
    mine = replace(Executor.here(), id=ELSEWHERE.id)
    with pytest.raises(ExecutorTakenError, match="another name"):
        executors.enter(mine, sleep=lambda _: [executors.beat(ELSEWHERE)].clear())


def test_a_beat_raises_the_counter_and_enters_again_whoever_was_removed(executors: ExecutorBook) -> None:
    mine = Executor.here("mine")
    executors.enter(mine)
    assert executors.beat(mine)
    assert executors.all() == [replace(mine, beat=1)]
    executors.remove(mine)
    assert executors.beat(mine)
    assert executors.all() == [mine]
    assert not executors.beat(replace(mine, holder="another"))


def test_names_tell_host_and_process_and_are_all_different() -> None:
    one, other = Executor.here(), Executor.here()
    assert one.id != other.id
    assert one.id.startswith(f"{platform.node()}-{os.getpid()}-")

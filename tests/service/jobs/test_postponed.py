"""Ends of jobs that are told later than their work is done."""

from datetime import UTC, datetime, timedelta

import pytest

from modallab.jobs.postponed import DueJob, Postponed, Timer

BEGAN = datetime(2026, 1, 1, tzinfo=UTC)


def after(seconds: float) -> datetime:
    return BEGAN + timedelta(seconds=seconds)


@pytest.mark.parametrize(
    ("elapsed", "seconds"),
    [(0.3, 5.0), (3.0, 5.0), (5.0, 5.0), (5.1, 10.0), (-3600.0, 5.0)],  # the last: the clock was set back
)
def test_a_job_ends_a_multiple_of_the_step_after_its_beginning(elapsed: float, seconds: float) -> None:
    later = Postponed(least=2.0, step=5.0)
    assert later.due(BEGAN.isoformat(), after(elapsed)) == after(seconds)


def test_a_job_takes_at_least_so_long() -> None:
    assert Postponed(least=12.0, step=5.0).due(BEGAN.isoformat(), after(1.0)) == after(15.0)
    assert Postponed(least=0.0, step=0.0).due(BEGAN.isoformat(), after(1.0)) == after(1.0)


def due_job(*, active: bool = True) -> DueJob:
    """Return a job that ends 5 s after its beginning."""
    return DueJob("a", BEGAN.isoformat(), after(5.0).isoformat(), active=active, good=True)


def test_a_job_is_over_when_its_time_has_come_and_a_cancelled_one_at_once() -> None:
    at = 0.0
    timer = Timer(clock=lambda: at)
    assert timer.over([due_job()], after(2.0)) == []
    at = 2.9
    assert timer.over([due_job()], after(4.9)) == []
    at = 3.1
    assert timer.over([due_job()], after(5.1)) == [due_job()]
    assert timer.over([due_job(active=False)], after(2.0)) == [due_job(active=False)]


@pytest.mark.parametrize("jump", [-3600.0, 3600.0])
def test_a_clock_that_is_set_changes_no_end_that_is_known(jump: float) -> None:
    at = 0.0
    timer = Timer(clock=lambda: at)
    timer.over([due_job()], after(2.0))
    at = 2.9
    assert timer.over([due_job()], after(4.9 + jump)) == []
    at = 3.1
    assert timer.over([due_job()], after(5.1 + jump)) == [due_job()]


def test_a_clock_that_was_set_back_delays_an_end_by_no_more_than_the_job_takes() -> None:
    assert due_job().rest(after(-3600.0)) == 5.0

"""The book of jobs: what has ended never changes again."""

import time
from collections.abc import Callable
from datetime import datetime

import pytest
import sqlalchemy as sa

from modallab.core.errors import NotFoundError
from modallab.jobs import book as module
from modallab.jobs.book import JobBook
from modallab.jobs.durable import JobPlace
from modallab.jobs.postponed import Postponed
from modallab.jobs.runner import JobState, QueueFullError, RequestKey
from modallab.store.place import StorePlace, engine_of
from modallab.store.viewer import Viewer, Visibility

Places = tuple[StorePlace, JobPlace]


def book_at(places: Places, queue_length: int = 3) -> JobBook:
    return JobBook(engine_of(places[0]), queue_length=queue_length)


def test_a_job_goes_from_the_queue_to_its_end(places: Places) -> None:
    book = book_at(places)
    job = book.open("update_and_store", {"seed": 1}, owner="me")
    assert (job.state, job.fraction, job.arguments) == (JobState.QUEUED, 0.0, {"seed": 1})
    assert book.start(job.id)
    assert book.progress(job.id, 0.5, "half way")
    assert (book.get(job.id).fraction, book.get(job.id).message) == (0.5, "half way")
    assert book.succeed(job.id)
    assert (book.get(job.id).state, book.get(job.id).fraction) == (JobState.SUCCEEDED, 1.0)


@pytest.mark.parametrize("end", [JobBook.succeed, JobBook.cancel, lambda b, i: b.fail(i, {"code": "x"})])
def test_what_has_ended_never_changes_again(places: Places, end: Callable[[JobBook, str], bool]) -> None:
    book = book_at(places)
    job = book.open("update_and_store", {}, owner="me")
    assert end(book, job.id)
    ended = book.get(job.id)
    changes = [book.start(job.id), book.progress(job.id, 0.1, ""), book.succeed(job.id), book.cancel(job.id)]
    assert not any(changes)
    assert not book.fail(job.id, {"code": "y"})
    assert book.get(job.id) == ended


def test_a_full_queue_takes_no_more_until_a_job_starts(places: Places) -> None:
    book = book_at(places, queue_length=2)
    first = book.open("update_and_store", {}, owner="me")
    book.open("update_and_store", {}, owner="me")
    with pytest.raises(QueueFullError):
        book.open("update_and_store", {}, owner="me")
    book.start(first.id)
    book.open("update_and_store", {}, owner="me")


def test_a_job_is_shown_to_its_owner_alone(places: Places) -> None:
    book = book_at(places)
    job = book.open("update_and_store", {}, owner="me")
    assert book.get(job.id, viewer=Viewer("me", Visibility.OWN)) == job
    with pytest.raises(NotFoundError):
        book.get(job.id, viewer=Viewer("you", Visibility.OWN))


def test_active_jobs_are_those_that_have_not_ended(places: Places) -> None:
    book = book_at(places)
    ids = [book.open("update_and_store", {}, owner="me").id for _ in range(3)]
    book.start(ids[0])
    book.cancel(ids[1])
    assert book.active() == [ids[0], ids[2]]


@pytest.mark.parametrize("error", [None, {"code": "assignment", "detail": "no"}])
def test_a_job_whose_end_is_told_later_runs_for_its_owner_and_for_nobody_who_works(
    places: Places, error: dict[str, str] | None
) -> None:
    book = book_at(places)
    job = book.open("update_and_store", {}, owner="me")
    book.start(job.id)
    running = book.get(job.id)
    book.postpone(job.id, Postponed(least=5.0, step=5.0), error)
    assert book.get(job.id) == running
    assert (book.active(), book.is_active(job.id), book.start(job.id)) == ([], False, False)
    (due,) = book.due()
    assert (due.id, due.active, due.good) == (job.id, True, error is None)
    assert book.end_due(job.id)
    ended = book.get(job.id)
    assert (ended.state, ended.error) == (JobState.FAILED if error else JobState.SUCCEEDED, error)
    assert ended.started is not None
    assert ended.ended is not None
    seconds = datetime.fromisoformat(ended.ended) - datetime.fromisoformat(ended.started)
    assert seconds.total_seconds() == 5.0  # not the time at which it was ended
    assert book.due() == []


def test_a_job_whose_end_is_told_later_can_be_cancelled(places: Places) -> None:
    book = book_at(places)
    job = book.open("update_and_store", {}, owner="me")
    book.start(job.id)
    book.postpone(job.id, Postponed(least=5.0, step=5.0), {"code": "assignment", "detail": "no"})
    assert book.cancel(job.id)
    assert [due.active for due in book.due()] == [False]
    assert not book.end_due(job.id)
    ended = book.get(job.id)
    assert (ended.state, ended.error, book.due()) == (JobState.CANCELLED, None, [])


def test_a_wait_is_estimated_by_the_latest_jobs_of_the_kind(
    book: JobBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    minutes = iter(range(60))
    monkeypatch.setattr(module, "_now", lambda: f"2026-01-01T00:{next(minutes):02}:00+00:00")
    done = book.open("update_and_store", {}, owner="me")
    book.start(done.id)
    book.succeed(done.id)  # a minute later
    first = book.open("update_and_store", {}, owner="me")
    second = book.open("update_and_store", {}, owner="me")
    assert (first.place, first.wait_estimate) == (1, 0.0)
    assert (second.place, second.wait_estimate) == (2, 60.0)
    book.start(first.id)
    waiting = book.get(second.id)
    assert (waiting.place, waiting.wait_estimate) == (1, 30.0)  # the other is half done, on average
    stranger = book.open("study_and_store", {}, owner="me")
    assert stranger.wait_estimate == 90.0
    last = book.open("update_and_store", {}, owner="me")
    assert (last.place, last.wait_estimate) == (3, None)  # nobody knows how long the study takes


def test_a_request_that_comes_twice_at_once_starts_one_job(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    book, request = book_at(places), RequestKey("mine", "digest")
    first = book.open("update_and_store", {}, owner="me", request=request)
    looked = book._of_request
    answers: list[Callable[..., object]] = [lambda *_: None, looked]  # not there yet at the first look
    monkeypatch.setattr(book, "_of_request", lambda *given: answers.pop(0)(*given))
    begin = time.monotonic()
    assert book.open("update_and_store", {}, owner="me", request=request).id == first.id
    assert time.monotonic() - begin < 25  # SQLite waits 30 s for a lock that its own thread holds
    assert len(book.find(owner="me")) == 1


def test_jobs_are_found_with_their_places_by_a_few_queries(places: Places) -> None:
    book = book_at(places, queue_length=100)
    opened = [book.open("update_and_store", {}, owner="me").id for _ in range(30)]
    queries: list[str] = []
    engine = engine_of(places[0])
    sa.event.listen(engine, "before_cursor_execute", lambda *given: queries.append(given[2]))
    found = book.find(owner="me")
    assert [job.place for job in found] == list(range(30, 0, -1))
    assert [job.id for job in found] == opened[::-1]
    assert len(queries) <= 5

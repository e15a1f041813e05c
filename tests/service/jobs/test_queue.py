"""The order of the queue: owners take turns, and what a job is told of its place is what happens."""

from collections.abc import Sequence

import pytest

from modallab.jobs.book import JobBook
from modallab.jobs.durable import JobPlace
from modallab.jobs.runner import Lane
from modallab.store.place import StorePlace, engine_of

Places = tuple[StorePlace, JobPlace]
TASK = "update_and_store"


@pytest.fixture
def book(places: Places) -> JobBook:
    """The book of the jobs of a class."""
    return JobBook(engine_of(places[0]), queue_length=1000)


def queued(book: JobBook, owner: str, n: int, lane: Lane = Lane.LONG) -> list[str]:
    return [book.open(TASK, {}, owner=owner, lane=lane).id for _ in range(n)]


def placed(book: JobBook, ids: Sequence[str]) -> list[int | None]:
    return [book.get(job_id).place for job_id in ids]


def next_of(book: JobBook, lane: Lane = Lane.LONG) -> str:
    """Start the first job of a lane and return its owner."""
    first = next(job for job in book.find(limit=500) if job.place == 1 and job.lane is lane)
    book.start(first.id)
    book.succeed(first.id)
    return first.owner


def test_whoever_comes_later_waits_for_one_job_of_each_other(book: JobBook) -> None:
    many = queued(book, "many", 20)
    assert placed(book, many) == list(range(1, 21))
    book.start(many[0])
    ann, bea = queued(book, "ann", 2), queued(book, "bea", 2)
    assert placed(book, [*ann, *bea]) == [1, 4, 2, 5]
    assert placed(book, many[1:4]) == [3, 6, 7]


def test_owners_take_turns_until_nothing_waits(book: JobBook) -> None:
    queued(book, "many", 6)
    queued(book, "ann", 2)
    assert [next_of(book) for _ in range(8)] == ["many", "ann", "many", "ann", *["many"] * 4]


def test_whoever_comes_back_again_and_again_keeps_nobody_waiting(book: JobBook) -> None:
    queued(book, "many", 5)
    served: list[str] = []
    queued(book, "ann", 1)
    queued(book, "bea", 1)
    for _ in range(12):
        served.append(next_of(book))
        if served[-1] != "many":
            queued(book, served[-1], 1)
    assert served.count("many") == 4
    assert abs(served.count("ann") - served.count("bea")) <= 1


def test_jobs_cancelled_in_the_queue_have_used_no_turn(book: JobBook) -> None:
    for job_id in queued(book, "ann", 10):
        book.cancel(job_id)
    bea = queued(book, "bea", 2)
    ann = queued(book, "ann", 1)
    assert placed(book, [*bea, *ann]) == [1, 3, 2]


def test_lanes_have_places_of_their_own(book: JobBook) -> None:
    long, short = queued(book, "ann", 3), queued(book, "ann", 2, Lane.SHORT)
    assert placed(book, long) == [1, 2, 3]
    assert placed(book, short) == [1, 2]
    assert [job.place for job in book.find(limit=500)] == [2, 1, 3, 2, 1]

"""The order of the queue: owners take turns, and what a job is told of its place is what happens."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import pytest
from alembic import command

from modallab.jobs.book import JobBook
from modallab.jobs.durable import JobPlace
from modallab.jobs.runner import Lane, QueueQuotaError
from modallab.store.keys import KeyBook, Role
from modallab.store.migrate import alembic_config
from modallab.store.place import StorePlace, engine_of
from modallab.store.quotas import Quotas
from modallab.store.viewer import LOCAL

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


def class_of(places: Places, n: int) -> list[str]:
    """Return the ids of the keys of a class."""
    keys = KeyBook(engine_of(places[0]))
    admin = keys.create("admin", Role.ADMIN).key
    (teacher,) = keys.create_several(["teacher"], Role.INSTRUCTOR)
    assert admin.role is Role.ADMIN
    members = keys.create_several([f"{i}" for i in range(n)], Role.STUDENT, class_id="class")
    return [teacher.key.id, *(new.key.id for new in members)]


def test_one_key_that_has_queued_too_much_is_refused_and_others_are_not(places: Places) -> None:
    book = JobBook(engine_of(places[0]), queue_length=100, quotas=Quotas(3, 5))
    teacher, ann, bea, cid = class_of(places, 3)
    mine = queued(book, ann, 3)
    with pytest.raises(QueueQuotaError, match="key"):
        book.open(TASK, {}, owner=ann)
    assert len(book.find(owner=ann)) == 3  # what was refused has left nothing
    book.start(mine[0])
    queued(book, ann, 1)
    queued(book, bea, 2)
    with pytest.raises(QueueQuotaError, match="class") as caught:
        book.open(TASK, {}, owner=cid)
    assert caught.value.context["allowed"] == 5
    queued(book, teacher, 3)  # of no class
    queued(book, LOCAL, 20)


def test_a_quota_holds_for_requests_that_come_at_once(places: Places) -> None:
    book = JobBook(engine_of(places[0]), queue_length=100, quotas=Quotas(5))

    def ask(_: int) -> bool:
        try:
            book.open(TASK, {}, owner="ann")
        except QueueQuotaError:
            return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(ask, range(24))) == 5
    assert {job.place for job in book.find(owner="ann")} == {1, 2, 3, 4, 5}
    assert sorted(job.turn for job in book.find(owner="ann")) == [0, 1, 2, 3, 4]


def test_jobs_that_waited_before_there_were_turns_come_first(places: Places, book: JobBook) -> None:
    old = queued(book, "many", 3)
    with engine_of(places[0]).begin() as connection:
        command.downgrade(alembic_config(connection), "0005")
    places[0].prepare()
    new = queued(book, "ann", 1) + queued(book, "many", 1)
    assert placed(book, [*old, *new]) == [1, 2, 3, 4, 5]

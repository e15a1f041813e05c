"""What is deleted can be had back for a day, and until then is as if it were gone."""

import threading
from datetime import UTC, datetime, timedelta

import pytest

from modallab.core.errors import NotFoundError
from modallab.store.arrays import FolderArrays
from modallab.store.base import InTrashError, InUseError, Truth
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.sql import SqlStore
from modallab.store.tables import THINGS
from modallab.store.trash import empty_trash, expired_before
from modallab.store.uses import lock_untrashed
from modallab.store.viewer import Viewer, Visibility
from tests.service.store.test_sql import BEAM, RIG, measurement


def aged(place: StorePlace, hours: float) -> None:
    """Let everything in the trash be there for so long."""
    time = (datetime.now(UTC) - timedelta(hours=hours)).isoformat(timespec="microseconds")
    with engine_of(place).begin() as connection:
        connection.execute(THINGS.update().where(THINGS.c.removed.is_not(None)).values(removed=time))


def swept(place: StorePlace) -> int:
    """Return how many things are removed because their day is over."""
    over = THINGS.c.removed < expired_before(datetime.now(UTC))
    return empty_trash(engine_of(place), FolderArrays(place.folder), over)


def in_trash(store: SqlStore, owner: str = "me") -> list[str]:
    return [thing.entry.id for thing in store.trash.list(owner=owner, limit=9)]


def test_what_is_deleted_is_gone_until_it_is_restored(store: SqlStore) -> None:
    test = store.measurements.add(measurement(), owner="me")
    entry = store.measurements.entry(test)
    store.measurements.discard(test)
    assert not store.measurements.holds(test)
    assert store.measurements.list(limit=9) == []
    with pytest.raises(NotFoundError, match="is in the trash until") as told:
        store.measurements.npz(test)
    (thing,) = store.trash.list(owner="me", limit=9)
    assert (thing.entry, thing.until) == (entry, told.value.context["until"])
    day = datetime.fromisoformat(thing.until) - datetime.fromisoformat(thing.removed)
    assert day == timedelta(hours=24)
    assert store.trash.restore(test) == entry
    assert store.measurements.get(test).averages == 94.8
    assert store.trash.list(owner="me", limit=9) == []


def test_what_is_in_the_trash_is_deleted_or_described_or_restored_no_second_time(store: SqlStore) -> None:
    id = store.rigs.add(RIG, owner="me")
    with pytest.raises(NotFoundError):
        store.trash.restore(id)
    store.rigs.discard(id)
    with pytest.raises(NotFoundError, match="in the trash"):
        store.rigs.discard(id)
    with pytest.raises(NotFoundError, match="no structure"):
        store.structures.get(id)


def test_after_a_day_it_is_gone_for_good_with_its_arrays(store: SqlStore, place: StorePlace) -> None:
    test = store.measurements.add(measurement(), owner="me")
    store.measurements.discard(test)
    assert swept(place) == 0
    aged(place, 25)
    with pytest.raises(NotFoundError, match="there is no measurement"):  # swept or not
        store.measurements.get(test)
    with pytest.raises(NotFoundError):
        store.trash.restore(test)
    assert in_trash(store) == []
    assert swept(place) == 1
    assert not list(place.folder.rglob("*.npz"))


def test_what_something_was_made_from_is_deleted_after_it_and_restored_before_it(store: SqlStore) -> None:
    base = store.structures.add(BEAM, owner="me")
    changed = store.structures.add(BEAM, owner="me", inputs={"structure_id": base})
    with pytest.raises(InUseError):
        store.structures.discard(base)
    assert store.structures.holds(base)
    store.structures.discard(changed)
    store.structures.discard(base)
    with pytest.raises(InTrashError):
        store.trash.restore(changed)
    assert in_trash(store) == [base, changed]
    with pytest.raises(InUseError):
        store.trash.remove(base)
    store.trash.restore(base)
    store.trash.restore(changed)
    assert store.structures.entry(changed).inputs == {"structure_id": base}


def test_both_go_for_good_in_one_sweep(store: SqlStore, place: StorePlace) -> None:
    base = store.structures.add(BEAM, owner="me")
    changed = store.structures.add(BEAM, owner="me", inputs={"structure_id": base})
    store.structures.discard(changed)
    store.structures.discard(base)
    aged(place, 25)
    assert swept(place) == 2


def test_a_tested_structure_stays_while_its_test_is_there(store: SqlStore) -> None:
    hidden = store.structures.add(BEAM, owner="me")
    test = store.measurements.add(measurement(), owner="me")
    store.truths.add(Truth(hidden, ()), measurement_id=test, owner="me")
    with pytest.raises(InUseError):
        store.structures.discard(hidden)
    store.measurements.discard(test)
    store.structures.discard(hidden)
    with pytest.raises(InTrashError) as told:
        store.trash.restore(test)
    assert hidden not in repr(told.value.context) + str(told.value)  # the truth is not told
    store.trash.restore(hidden)
    store.trash.restore(test)
    assert store.truths.get(test, owner="me").structure_id == hidden


def test_nothing_is_made_from_what_is_in_the_trash(store: SqlStore) -> None:
    base = store.structures.add(BEAM, owner="me")
    store.structures.discard(base)
    with pytest.raises(NotFoundError):
        store.structures.add(BEAM, owner="me", inputs={"structure_id": base}, id="orphan")

    def tested() -> None:
        with store.together() as batch:
            test = batch.measurements.add(measurement(), owner="me", id="test")
            batch.truths.add(Truth(base, ()), measurement_id=test, owner="me")

    with pytest.raises(NotFoundError):
        tested()
    store.trash.restore(base)
    assert not store.structures.holds("orphan")
    assert not store.measurements.holds("test")


def test_who_deletes_waits_for_who_is_about_to_use(store: SqlStore, place: StorePlace) -> None:
    base = store.structures.add(BEAM, owner="me")
    used, refused = threading.Event(), list[str]()

    def delete() -> None:
        used.wait()
        try:
            store.structures.discard(base)
        except InUseError:
            refused.append(base)

    thread = threading.Thread(target=delete)
    thread.start()
    with store.together() as batch:
        batch.structures.add(BEAM, owner="me", inputs={"structure_id": base})
        used.set()
        thread.join(timeout=0.3)  # it waits: what was added is not to be seen yet
        assert thread.is_alive()
    thread.join()
    assert refused == [base]
    with engine_of(place).begin() as connection:
        assert lock_untrashed(connection, [base])


def test_what_is_made_anew_under_the_same_id_is_there_again(store: SqlStore) -> None:
    store.rigs.add(RIG, owner="me", id="chosen")
    store.rigs.discard("chosen")
    assert store.rigs.add(RIG, owner="me", id="chosen") == "chosen"
    assert store.rigs.get("chosen") == RIG


def test_the_trash_is_its_owners(store: SqlStore, place: StorePlace) -> None:
    id = store.rigs.add(RIG, owner="me")
    other = open_store(place).as_seen_by(Viewer("you", Visibility.OWN))
    with pytest.raises(NotFoundError):
        other.rigs.discard(id)
    store.rigs.discard(id)
    for call in (other.trash.restore, other.trash.remove):
        with pytest.raises(NotFoundError, match="in the trash"):
            call(id)
    with pytest.raises(NotFoundError, match="there is no rig"):
        other.rigs.get(id)
    assert other.trash.list(owner="me", limit=9) == []
    mine = open_store(place).as_seen_by(Viewer("me", Visibility.OWN))
    assert in_trash(mine) == [id]
    mine.trash.remove(id)
    assert in_trash(mine) == []


def test_the_trash_is_listed_page_by_page(store: SqlStore) -> None:
    ids = [store.rigs.add(RIG, owner="me") for _ in range(5)]
    for id in ids:
        store.rigs.discard(id)
    pages = [store.trash.list(owner="me", limit=3)]
    pages.append(store.trash.list(owner="me", limit=3, cursor=pages[0][-1].entry.id))
    assert [thing.entry.id for page in pages for thing in page] == ids[::-1]
    with pytest.raises(NotFoundError):
        store.trash.list(owner="me", limit=3, cursor="none")

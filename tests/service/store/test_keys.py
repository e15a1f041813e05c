"""Keys: none can be read from the database, and none counts after its end."""

from datetime import UTC, datetime, timedelta

import pytest
import sqlalchemy as sa

from modallab.core.errors import InvalidInputError, NotFoundError
from modallab.fe.catalogued import STRUCTURES
from modallab.store.base import Description, ForbiddenError, UnauthorisedError
from modallab.store.classes import ClassBook
from modallab.store.keys import Key, KeyBook, Role, written
from modallab.store.place import StorePlace, engine_of
from modallab.store.sessions import SessionBook
from modallab.store.sign_in_links import VALID, LinkBook
from modallab.store.sql import SqlStore
from modallab.store.tables import METADATA
from modallab.store.viewer import EVERYONE

BEAM = STRUCTURES["bay"]()


@pytest.fixture
def keys(place: StorePlace) -> KeyBook:
    """Keys of a place, an administrator's among them."""
    keys = KeyBook(engine_of(place))
    keys.create("root", Role.ADMIN)
    return keys


@pytest.fixture
def classes(place: StorePlace, keys: KeyBook) -> ClassBook:
    """Classes of a place."""
    return ClassBook(engine_of(place), keys)


@pytest.fixture
def sessions(place: StorePlace) -> SessionBook:
    """Sessions of a place."""
    return SessionBook(engine_of(place))


@pytest.fixture
def links(place: StorePlace) -> LinkBook:
    """Links of a place."""
    return LinkBook(engine_of(place))


def secret_of(links: LinkBook, key: Key) -> str:
    return links.create(key).link.removeprefix("/#once=")


def test_no_row_of_the_database_holds_a_key_a_cookie_or_a_link(
    place: StorePlace, keys: KeyBook, sessions: SessionBook, links: LinkBook
) -> None:
    new = keys.create("somebody", Role.STUDENT)
    secrets = {
        new.text.removeprefix(f"modallab_{new.key.id}_"),
        sessions.create(new.key).cookie,
        secret_of(links, new.key),
    }
    with engine_of(place).begin() as connection:
        rows = [row for table in METADATA.sorted_tables for row in connection.execute(sa.select(table))]
    assert len(rows) == 4  # two keys, a session, a link
    assert not [secret for secret in secrets if secret in str(rows)]


def test_a_key_is_known_by_its_text_alone(keys: KeyBook) -> None:
    new = keys.create("somebody", Role.STUDENT)
    assert keys.verified(new.text) == new.key
    other = keys.create("another", Role.STUDENT)
    mixed = f"modallab_{new.key.id}_{other.text.split('_', 2)[2]}"
    for text in ("", "modallab_", new.key.id, new.text[:-1], f"{new.text}x", mixed):
        with pytest.raises(UnauthorisedError, match="not known"):
            keys.verified(text)


def test_an_expired_key_does_not_count(keys: KeyBook) -> None:
    now = datetime.now(UTC)
    keys.verified(keys.create("valid", Role.STUDENT, expires=now + timedelta(minutes=1)).text)
    with pytest.raises(UnauthorisedError, match="expired"):
        keys.verified(keys.create("late", Role.STUDENT, expires=now).text)


def test_a_revoked_key_ends_with_its_session(keys: KeyBook, sessions: SessionBook) -> None:
    new = keys.create("somebody", Role.STUDENT)
    cookie = sessions.create(new.key).cookie
    assert sessions.key(cookie) == new.key
    keys.revoke(new.key.id, viewer=EVERYONE)
    with pytest.raises(UnauthorisedError, match="revoked"):
        keys.verified(new.text)
    with pytest.raises(UnauthorisedError, match="revoked"):
        sessions.key(cookie)
    with pytest.raises(InvalidInputError, match="revoked"):
        keys.rotate(new.key.id, viewer=EVERYONE)


def test_a_renewed_key_has_the_same_owner_and_another_text(keys: KeyBook, sessions: SessionBook) -> None:
    new = keys.create("somebody", Role.STUDENT)
    cookie = sessions.create(new.key).cookie
    renewed = keys.rotate(new.key.id, viewer=EVERYONE)
    assert keys.verified(renewed.text).id == new.key.id
    with pytest.raises(UnauthorisedError):
        keys.verified(new.text)
    with pytest.raises(UnauthorisedError):
        sessions.key(cookie)


def test_a_link_counts_once_and_for_the_last_time_before_it_expires(
    keys: KeyBook, links: LinkBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = keys.create("somebody", Role.STUDENT).key
    once, late, longer = (secret_of(links, key) for _ in range(3))
    assert links.used(once) == key
    for worn in (once, "", "unknown"):
        with pytest.raises(UnauthorisedError, match="has been used"):
            links.used(worn)

    def in_time(later: timedelta) -> str:
        return written(datetime.now(UTC) + later)

    monkeypatch.setattr("modallab.store.sign_in_links.now", lambda: in_time(VALID - timedelta(minutes=1)))
    assert links.used(longer) == key
    monkeypatch.setattr("modallab.store.sign_in_links.now", lambda: in_time(VALID))
    with pytest.raises(UnauthorisedError, match="too old"):
        links.used(late)


def test_a_link_ends_with_its_key(keys: KeyBook, links: LinkBook) -> None:
    new = keys.create("somebody", Role.STUDENT)
    before_renewal = secret_of(links, new.key)
    keys.rotate(new.key.id, viewer=EVERYONE)
    with pytest.raises(UnauthorisedError):
        links.used(before_renewal)
    before_the_end = secret_of(links, new.key)
    keys.revoke(new.key.id, viewer=EVERYONE)
    with pytest.raises(UnauthorisedError, match="revoked"):
        links.used(before_the_end)
    with pytest.raises(InvalidInputError, match="revoked"):
        links.create(keys.get(new.key.id, viewer=EVERYONE))


def test_the_first_key_is_an_administrators(place: StorePlace) -> None:
    keys = KeyBook(engine_of(place))
    with pytest.raises(InvalidInputError, match="first key"):
        keys.create("somebody", Role.STUDENT)
    assert not keys.exists()
    keys.create("root", Role.ADMIN)
    assert keys.exists()
    assert KeyBook(engine_of(place)).exists()


def test_a_list_of_members_makes_each_key_once(keys: KeyBook, classes: ClassBook) -> None:
    teacher = keys.create("teacher", Role.INSTRUCTOR).key
    end = datetime(2040, 1, 1, tzinfo=UTC)
    entered = classes.create("class", owner=teacher.id, expires=end)
    members = classes.add_members(entered.id, ["a", "b"], viewer=teacher.viewer)
    assert [new.key.name for new in members] == ["a", "b"]
    assert {new.key.expires for new in members} == {"2040-01-01T00:00:00.000000+00:00"}
    for names in (["c", "a"], ["c", "c"]):
        with pytest.raises(InvalidInputError, match="already"):
            classes.add_members(entered.id, names, viewer=teacher.viewer)
    assert len(keys.list(viewer=teacher.viewer, class_id=entered.id)) == 2


def test_a_closed_class_has_no_valid_keys_and_keeps_its_results(
    store: SqlStore, keys: KeyBook, classes: ClassBook
) -> None:
    teacher = keys.create("teacher", Role.INSTRUCTOR).key
    entered = classes.create("class", owner=teacher.id)
    [member] = classes.add_members(entered.id, ["a"], viewer=teacher.viewer)
    made = store.structures.add(BEAM, owner=member.key.id)
    classes.close(entered.id, viewer=teacher.viewer)
    with pytest.raises(UnauthorisedError):
        keys.verified(member.text)
    with pytest.raises(NotFoundError):
        classes.get(entered.id, viewer=teacher.viewer)
    assert classes.list(viewer=teacher.viewer) == []
    assert store.as_seen_by(teacher.viewer).structures.entry(made).owner == member.key.id


def test_what_is_shared_with_a_class_is_its_members_to_read_and_not_to_remove(
    store: SqlStore, keys: KeyBook, classes: ClassBook
) -> None:
    teacher = keys.create("teacher", Role.INSTRUCTOR).key
    here, there = (classes.create(name, owner=teacher.id) for name in ("here", "there"))
    member, stranger = (
        store.as_seen_by(classes.add_members(c.id, ["a"], viewer=teacher.viewer)[0].key.viewer)
        for c in (here, there)
    )
    thing = store.structures.add(BEAM, owner=teacher.id)
    classes.share(here.id, thing, viewer=teacher.viewer)
    classes.share(here.id, thing, viewer=teacher.viewer)
    assert [entry.id for entry in member.structures.list(limit=9)] == [thing]
    assert member.structures.get(thing).members == BEAM.members
    with pytest.raises(ForbiddenError, match="shared"):
        member.structures.remove(thing)
    with pytest.raises(ForbiddenError, match="shared"):
        member.structures.describe(thing, Description("mine"))
    assert not stranger.structures.holds(thing)
    assert classes.shares(here.id) == [thing]
    classes.withdraw(here.id, thing, viewer=teacher.viewer)
    assert not member.structures.holds(thing)
    with pytest.raises(NotFoundError):
        classes.withdraw(here.id, thing, viewer=teacher.viewer)
    classes.share(here.id, thing, viewer=teacher.viewer)
    store.as_seen_by(teacher.viewer).structures.remove(thing)
    assert classes.shares(here.id) == []


def test_nobody_shares_what_is_not_theirs(store: SqlStore, keys: KeyBook, classes: ClassBook) -> None:
    teacher, other = (keys.create(name, Role.INSTRUCTOR).key for name in ("teacher", "other"))
    entered = classes.create("class", owner=teacher.id)
    for thing in (store.structures.add(BEAM, owner=other.id), "gone"):
        with pytest.raises(NotFoundError):
            classes.share(entered.id, thing, viewer=teacher.viewer)


def test_what_was_stored_without_keys_is_for_instructors_and_administrators(
    store: SqlStore, keys: KeyBook
) -> None:
    thing = store.structures.add(BEAM, owner=EVERYONE.owner)
    readers = {
        role: store.as_seen_by(keys.create(role, role).key.viewer).structures.holds(thing) for role in Role
    }
    assert readers == {Role.ADMIN: True, Role.INSTRUCTOR: True, Role.STUDENT: False, Role.SERVICE: False}

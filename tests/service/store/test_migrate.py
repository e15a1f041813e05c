"""The migrations lead to the tables, and only there."""

import sqlalchemy as sa
from alembic import command

from modallab.fe.catalogued import STRUCTURES
from modallab.store.migrate import alembic_config
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.tables import THINGS


def test_the_migrations_lead_to_the_tables_of_the_code(place: StorePlace) -> None:
    with engine_of(place).begin() as connection:
        command.check(alembic_config(connection))


def test_preparing_twice_changes_nothing(place: StorePlace) -> None:
    place.prepare()


def test_the_way_down_is_the_way_up_again(place: StorePlace) -> None:
    with engine_of(place).begin() as connection:
        command.downgrade(alembic_config(connection), "base")
    place.prepare()
    with engine_of(place).begin() as connection:
        command.check(alembic_config(connection))


def test_what_was_stored_before_there_were_keys_is_read_afterwards(place: StorePlace) -> None:
    structure = STRUCTURES["bay"]()
    id = open_store(place).structures.add(structure, owner="local")
    with engine_of(place).begin() as connection:
        command.downgrade(alembic_config(connection), "0003")
        assert not sa.inspect(connection).has_table("keys")
    place.prepare()
    store = open_store(place)
    assert store.structures.get(id).members == structure.members
    entries = [(entry.owner, entry.name) for entry in store.structures.list(limit=9)]
    assert entries == [("local", structure.name)]


def test_what_was_stored_before_there_were_quotas_counts_without_its_arrays(place: StorePlace) -> None:
    open_store(place).structures.add(STRUCTURES["bay"](), owner="me")
    size = sa.select(THINGS.c.size)
    with engine_of(place).begin() as connection:
        before = connection.execute(size).scalar_one()
        command.downgrade(alembic_config(connection), "0005")
    place.prepare()
    with engine_of(place).begin() as connection:
        assert connection.execute(size).scalar_one() == before > 0  # a structure has no arrays


def test_what_was_stored_before_bodies_were_kept_has_none(place: StorePlace) -> None:
    id = open_store(place).structures.add(STRUCTURES["bay"](), owner="me", request={"kind": "catalogue"})
    assert open_store(place).structures.request(id) == {"kind": "catalogue"}
    with engine_of(place).begin() as connection:
        command.downgrade(alembic_config(connection), "0009")
    place.prepare()
    assert open_store(place).structures.request(id) is None


def test_what_is_in_the_trash_is_there_for_a_version_without_it(place: StorePlace) -> None:
    store = open_store(place)
    id = store.structures.add(STRUCTURES["bay"](), owner="me")
    store.structures.discard(id)
    with engine_of(place).begin() as connection:
        command.downgrade(alembic_config(connection), "0010")
    place.prepare()
    assert store.structures.holds(id)

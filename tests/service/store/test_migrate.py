"""The migrations lead to the tables, and only there."""

from alembic import command

from modallab.store.migrate import alembic_config
from modallab.store.place import StorePlace, engine_of


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

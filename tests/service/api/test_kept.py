"""Retention on everything that a class makes: what is kept refers to nothing that was removed."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

import sqlalchemy as sa

from modallab.api.runners import job_book
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import DiagnosisInputs, FurtherTest
from modallab.jobs.retention import Retention
from modallab.store.base import Description
from modallab.store.place import engine_of
from modallab.store.tables import METADATA, THINGS
from tests.diagnosed import diagnosis
from tests.service.api.authorisation import School, fill, open_school
from tests.service.jobs.test_reconciler import Engine

LATER = datetime.now(UTC) + timedelta(days=31)


def texts(value: Any) -> Iterator[str]:
    """Yield every text in a value of a column."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for entry in (*value, *value.values()):
            yield from texts(entry)
    elif isinstance(value, list):
        for entry in value:
            yield from texts(entry)


def named_things(engine: sa.Engine, ids: set[str]) -> dict[str, str]:
    """Return which of these ids are written anywhere in the database, each with a table that has it."""
    with engine.begin() as connection:
        return {
            text: table.name
            for table in METADATA.tables.values()
            for row in connection.execute(sa.select(table))
            for value in row
            for text in texts(value)
            if text in ids
        }


def diagnosed_again(school: School) -> str:
    """Return the id of a diagnosis with an earlier one and a further test."""
    ids, store = school.ids, school.service.app.state.store
    test = {"structure_id": ids["structure"], "rig_id": ids["rig"], "route": "expected"}
    further = FurtherTest(school.made("/v1/measurements", test), {})
    inputs = DiagnosisInputs(ids["structure"], ids["measurement"], (further,))
    inputs.keep(store, Destination(ids["student"], "again"), diagnosis(), [ids["diagnosis"]])
    return "again"


def test_nothing_that_is_kept_refers_to_what_was_removed(service: Any) -> None:
    school = open_school(service)
    fill(school)
    settings, store = service.app.state.settings, service.app.state.store
    engine = engine_of(settings.store_place)
    for shelf, name in ((store.modal_models, "global_model"), (store.studies, "study")):
        shelf.describe(school.ids[name], Description(comment="kept"))
    store.diagnoses.describe(diagnosed_again(school), Description(name="kept"))
    with engine.begin() as connection:
        before = set(connection.execute(sa.select(THINGS.c.id)).scalars())
    _, removed = Retention(job_book(settings), settings.store_place, 30.0).sweep(Engine(), now=LATER)
    assert removed > 0
    with engine.begin() as connection:
        left = set(connection.execute(sa.select(THINGS.c.id)).scalars())
    assert school.ids["update"] in before - left
    assert named_things(engine, before - left) == {}

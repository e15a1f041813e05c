"""Retention: what is old and nobody named is removed, and nothing that is still of use."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import anyio
import numpy as np
import pytest
import sqlalchemy as sa
from anyio import to_thread

from modallab.core.errors import NotFoundError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.jobs.durable import DurableRunner
from modallab.jobs.retention import Retention
from modallab.jobs.runner import JobState
from modallab.jobs.settings import JOB
from modallab.store.base import Description
from modallab.store.classes import ClassBook
from modallab.store.keys import KeyBook, Role
from modallab.store.place import engine_of, open_store
from modallab.store.tables import SHARES
from modallab.updating.options import UpdateOptions
from tests.service.jobs.lasting import Places, arguments, book_at, run, until
from tests.service.jobs.test_reconciler import Engine

LATER = datetime.now(UTC) + timedelta(days=31)
Modes = Callable[[str], str]

pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <function BaseConnection.__del__:pytest.PytestUnraisableExceptionWarning"
)


def swept(places: Places, now: datetime = LATER) -> tuple[int, int]:
    return Retention(book_at(places), places[0], 30.0).sweep(Engine(), now=now)


def files_of(places: Places) -> list[Path]:
    return list(places[0].folder.rglob("*.npz"))


@pytest.fixture
def model(places: Places) -> str:
    """A structure that has no name but that of its description."""
    return open_store(places[0]).structures.add(STRUCTURES["bay"](), owner="me")


@pytest.fixture
def modes(places: Places) -> Modes:
    """Store modes that were made from a structure."""
    bay = STRUCTURES["bay"]()
    made = synthetic_modes(assemble(bay), 3, bay.dofs, noise=ModeNoise(), rng=np.random.default_rng(0))
    shelf = open_store(places[0]).modal_models
    return lambda id: shelf.add(made, owner="me", inputs={"structure_id": id})


def test_what_nobody_named_goes_with_what_it_was_made_from(places: Places, model: str, modes: Modes) -> None:
    modes(model)
    assert files_of(places)
    assert swept(places, datetime.now(UTC)) == (0, 0)  # nothing is old
    assert swept(places) == (0, 2)
    assert not open_store(places[0]).structures.holds(model)
    assert not files_of(places)


@pytest.mark.parametrize(
    "said", [Description(name="mine"), Description(labels=["week 3"]), Description(comment="see page 4")]
)
def test_what_somebody_named_stays_with_what_it_was_made_from(
    places: Places, model: str, modes: Modes, said: Description
) -> None:
    named = modes(model)
    modes(model)
    store = open_store(places[0])
    store.modal_models.describe(named, said)
    assert swept(places) == (0, 1)
    assert store.modal_models.holds(named)
    assert store.structures.holds(model)
    store.modal_models.get(named)  # with its arrays


def test_what_was_deleted_goes_after_a_day_with_a_name_too(places: Places, model: str, modes: Modes) -> None:
    store, place = open_store(places[0]), places[0]
    named = modes(model)
    store.modal_models.describe(named, Description(name="mine"))
    store.modal_models.discard(named)
    without_days = Retention(book_at(places), place, None)
    assert without_days.sweep(Engine(), now=datetime.now(UTC) + timedelta(hours=23)) == (0, 0)
    assert without_days.sweep(Engine(), now=datetime.now(UTC) + timedelta(hours=25)) == (0, 1)
    assert not files_of(places)
    assert store.structures.holds(model)
    store.structures.discard(model)
    assert Retention(book_at(places), place, 1e-6).sweep(Engine(), now=datetime.now(UTC)) == (0, 0)
    store.trash.restore(model)  # old, and yet deleted a moment ago


def test_a_structure_stays_once_its_owner_gives_it_a_name(places: Places, model: str) -> None:
    open_store(places[0]).structures.describe(model, Description(name="my bay"))
    assert swept(places) == (0, 0)


def test_what_a_class_shares_stays(places: Places, model: str) -> None:
    engine = engine_of(places[0])
    keys = KeyBook(engine)
    keys.create("admin", Role.ADMIN)
    teacher = keys.create("teacher", Role.INSTRUCTOR).key
    course = ClassBook(engine, keys).create("dynamics", owner=teacher.id)
    with engine.begin() as connection:
        connection.execute(SHARES.insert().values(class_id=course.id, thing_id=model))
    assert swept(places) == (0, 0)


def test_what_a_waiting_job_needs_stays_until_it_has_ended(places: Places) -> None:
    book = book_at(places)
    job = book.open("update_and_store", arguments(places, UpdateOptions()), owner="me")
    assert swept(places) == (0, 0)
    book.cancel(job.id)
    assert swept(places) == (1, 2)
    with pytest.raises(NotFoundError):
        book.get(job.id)


def test_the_engine_forgets_a_job_too(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modallab.jobs.reconciler.JOB", replace(JOB, sweep_interval=0.0))

    async def work(runner: DurableRunner) -> None:
        given = arguments(places, UpdateOptions(max_iterations=2))
        job = await to_thread.run_sync(partial(runner.submit, "update_and_store", given, owner="me"))
        with pytest.raises(NotFoundError):
            await until(runner, job, lambda j: j.state is JobState.FAILED)
        with anyio.fail_after(20):  # things go after jobs
            while await to_thread.run_sync(open_store(places[0]).updates.holds, job.result_id):
                await anyio.sleep(0.1)
        with runner._engine.begin() as connection:
            table = (
                "workflow_status" if "sqlite" in places[1].url else f'"{places[1].schema}".workflow_status'
            )
            assert connection.execute(sa.text(f"SELECT count(*) FROM {table}")).scalar_one() == 0

    run(places, work, retention=Retention(book_at(places), places[0], 1e-9))

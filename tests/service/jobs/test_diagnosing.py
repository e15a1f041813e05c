"""Diagnoses as jobs: further tests that they run, attempts that die, and the truth, which is out of reach."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import pytest
import sqlalchemy as sa

from modallab.core.dof import Dof
from modallab.core.errors import CancelledError
from modallab.core.place import EffectSpec
from modallab.core.progress import silent
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.options import DiagnosisOptions
from modallab.jobs import diagnosing
from modallab.jobs.book import JobBook
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import DiagnosisInputs, FurtherTest
from modallab.jobs.tasks import DIAGNOSIS, TASKS
from modallab.rig.setup import RigSetup
from modallab.store.base import Truth
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.plain import to_plain
from modallab.store.sql import SqlStore
from modallab.store.tables import TRUTHS
from tests.diagnosing import model, rig

HIDDEN = EffectSpec("extra_mass", Dof(1, "Y"), {"mass": 0.02})
OTHER = EffectSpec("stiffness_error", None, {"factor": 3.0})


def prepared(folder: Path) -> StorePlace:
    """Return an empty store."""
    place = StorePlace(f"sqlite:///{folder / 'modallab.sqlite'}", "unused", folder / "arrays")
    place.prepare()
    return place


def small() -> RigSetup:
    """Return a rig of three fixed accelerometers and few lines."""
    setup = rig(roving=False)
    analyser = replace(setup.analyser, n_lines=61, frequency_max=240.0)
    return replace(setup, responses=setup.responses[::2], analyser=analyser)


@pytest.fixture
def place(tmp_path: Path) -> Iterator[StorePlace]:
    """A store with a model, a rig, and a test of the model with a mass that no log book shows."""
    place = prepared(tmp_path)
    store = open_store(place)
    store.structures.add(model(), owner="me", id="model")
    store.rigs.add(small(), owner="me", id="rig")
    effects = to_plain((HIDDEN,))[0]
    given = {"structure_id": "model", "rig_id": "rig", "effects": effects, "route": "drawn", "seed": 1}
    TASKS["measure_and_store"](store, silent, Destination("me", "test"), **given)
    yield place
    engine_of(place).dispose()


def question(**more: Any) -> dict[str, Any]:
    """Return the arguments of a diagnosis that two suspects explain alike."""
    follow_ups = tuple(more.pop("follow_ups", ()))
    options: dict[str, Any] = {"suspects": ("extra_mass", "force_transducer_mass"), "max_effects": 1} | more
    return DIAGNOSIS.arguments(DiagnosisInputs("model", "test", follow_ups), DiagnosisOptions(**options))


def diagnosed(store: SqlStore, id: str, *, progress: Any = silent, **more: Any) -> bytes:
    """Diagnose, and return all that was found as bytes."""
    TASKS["diagnose_and_store"](store, progress, Destination("me", id), **question(**more))
    return everything(store, id)


def everything(store: SqlStore, id: str) -> bytes:
    found = store.diagnoses.get(id)
    return repr(to_plain(found)[0]).encode() + store.diagnoses.npz(id)


def made(store: SqlStore, id: str) -> list[FurtherTest]:
    """Return the further tests that a diagnosis has run, as another one takes them."""
    changes = store.diagnoses.get(id).follow_ups
    ids = [store.diagnoses.entry(id).inputs[f"follow_up_{n}"] for n in range(1, len(changes) + 1)]
    return [FurtherTest(m, dict(c)) for m, c in zip(ids, changes, strict=True)]


class Sealed:
    """A shelf of truths that nobody may open."""

    def __getattr__(self, name: str) -> NoReturn:
        raise AssertionError(f"the truth was asked for: {name}")


def test_the_truth_is_shut_away_whenever_something_is_found_out(
    place: StorePlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = open_store(place)
    shelf, calls = store.truths, []

    def watched(*given: Any, **more: Any) -> Any:
        store.truths = Sealed()  # type: ignore[assignment]
        calls.append(len(more["follow_ups"]))
        found = diagnose_with_options(*given, **more)
        store.truths = shelf
        return found

    monkeypatch.setattr(diagnosing, "diagnose_with_options", watched)
    diagnosed(store, "found", act=True)
    assert calls == [0, 1]  # once with the first test, once with the further one
    assert store.diagnoses.get("found").steps[0].effect.kind == "extra_mass"


def test_another_truth_after_the_test_gives_the_same_diagnosis_to_the_byte(place: StorePlace) -> None:
    store = open_store(place)
    acted = diagnosed(store, "acted", act=True)
    follow_ups = made(store, "acted")
    assert len(follow_ups) == 1
    alone = diagnosed(store, "alone")
    together = diagnosed(store, "together", follow_ups=follow_ups)
    assert together == acted
    lie = to_plain(Truth("model", (OTHER,)))[0]
    with engine_of(place).begin() as connection:
        assert connection.execute(TRUTHS.update().values(body=lie)).rowcount == 2
    assert diagnosed(store, "alone again") == alone
    assert diagnosed(store, "together again", follow_ups=follow_ups) == together


# What a worker does with one job, in a process of its own.
WORK = """
import sys
from pathlib import Path
from modallab.jobs.work import perform
from modallab.store.place import StorePlace
url, folder, job = sys.argv[1:]
print(perform(StorePlace(url, "unused", Path(folder)), job) or "done")
"""


def test_a_process_without_any_truth_finds_the_same(place: StorePlace, tmp_path: Path) -> None:
    store = open_store(place)
    diagnosed(store, "acted", act=True)
    follow_ups = made(store, "acted")
    folder = tmp_path / "apart"
    folder.mkdir()
    apart = prepared(folder)
    bare = open_store(apart)
    bare.structures.add(model(), owner="me", id="model")
    for id in ("test", follow_ups[0].measurement_id):
        bare.measurements.add(store.measurements.get(id), owner="me", id=id)
    with engine_of(apart).begin() as connection:
        assert connection.execute(sa.select(sa.func.count()).select_from(TRUTHS)).scalar_one() == 0
    job = JobBook(engine_of(apart), queue_length=9).open(
        "diagnose_and_store", question(follow_ups=follow_ups), owner="me"
    )
    run = subprocess.run(
        [sys.executable, "-c", WORK, apart.url, str(apart.folder), job.id],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert run.stdout.strip() == "done"
    assert everything(bare, job.result_id) == everything(store, "acted")
    engine_of(apart).dispose()


def test_a_test_whose_truth_is_gone_is_not_repeated_but_diagnosed(place: StorePlace) -> None:
    store = open_store(place)
    with engine_of(place).begin() as connection:
        connection.execute(TRUTHS.delete())
    diagnosed(store, "found", act=True)
    found = store.diagnoses.get("found")
    assert found.next_test is not None
    assert any("could not be run" in note for note in found.notes)


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that grows with every diagnosis, by the number of further tests it has."""
    calls: list[int] = []

    def watched(*given: Any, **more: Any) -> Any:
        calls.append(len(more["follow_ups"]))
        return diagnose_with_options(*given, **more)

    monkeypatch.setattr(diagnosing, "diagnose_with_options", watched)
    return calls


@pytest.mark.parametrize("where", ["measured", "scanning"])
def test_an_attempt_that_dies_is_taken_up_where_it_was(
    place: StorePlace, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    store = open_store(place)
    undisturbed = diagnosed(store, "undisturbed", act=True)
    calls = counted(monkeypatch)

    def dying(fraction: float, message: str) -> None:
        # In the further test, or in the diagnosis after it: beyond the first round's share.
        if fraction > 0.85 / 3 and message.startswith(where):
            raise CancelledError("died")

    with pytest.raises(CancelledError):
        diagnosed(store, "again", progress=dying, act=True)
    assert not store.diagnoses.holds("again")
    tried = len(calls)
    assert diagnosed(store, "again", act=True) == undisturbed
    assert calls[tried:] == [1]  # the first diagnosis is not made twice
    listed = store.measurements.list(owner="me", limit=9)
    assert len(listed) == 3  # the first test, and one further test for each diagnosis


def test_progress_rises_over_diagnoses_and_tests(place: StorePlace) -> None:
    told: list[float] = []
    diagnosed(open_store(place), "found", act=True, progress=lambda fraction, _: told.append(fraction))
    assert told == sorted(told)
    assert told[-1] <= 1

"""Updates as jobs: one task for all families of methods."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab.core.progress import silent
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.jobs.destination import Destination
from modallab.jobs.tasks import TASKS
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.plain import to_plain
from modallab.store.sql import SqlStore
from modallab.updating.direct.method import DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.error_location.method import LocationResult
from modallab.updating.method import UpdateResult
from modallab.updating.options import LocationOptions, UpdateOptions
from modallab.updating.parameterisation import parameterise

PAIRS = to_plain(parameterise([[n, n + 1] for n in range(1, 20, 2)], ["stiffness"]))[0]
ASKED: dict[str, tuple[type, dict[str, Any]]] = {
    "inverse_eigensensitivity": (
        UpdateResult,
        {"options": to_plain(UpdateOptions(max_iterations=2))[0], "parameterisation": PAIRS},
    ),
    "zhang_subspace": (
        LocationResult,
        {"options": to_plain(LocationOptions())[0], "parameterisation": PAIRS},
    ),
    "berman_nagy": (DirectResult, {"options": to_plain(DirectOptions())[0]}),
}


@pytest.fixture
def store(tmp_path: Path) -> Iterator[SqlStore]:
    """A store with the beam, and modes of one with two stiffer members at all its degrees of freedom."""
    place = StorePlace(f"sqlite:///{tmp_path / 'modallab.sqlite'}", "unused", tmp_path / "arrays")
    place.prepare()
    filled, beam = open_store(place), STRUCTURES["chapter-5-beam"]()
    stiffer = change(beam, [MemberChange((11, 12), MemberProperty.MODULUS, factor=1.5)])
    filled.structures.add(beam, owner="me", id="model")
    exact = ModeNoise(eigenvalue=0.0, eigenvector=0.0)
    modes = synthetic_modes(assemble(stiffer), 5, beam.dofs, noise=exact, rng=np.random.default_rng(0))
    filled.modal_models.add(modes, owner="me", id="modes")
    yield filled
    engine_of(place).dispose()


def updated(store: SqlStore, task: str, method: str) -> Any:
    """Run a task, as often as after a crash, and return what it kept."""
    given = {"structure_id": "model", "modal_model_id": "modes", "method": method} | ASKED[method][1]
    for _ in range(2):
        TASKS[task](store, silent, Destination("me", "update"), **given)
    assert [entry.id for entry in store.updates.list(owner="me", limit=9)] == ["update"]
    return store.updates.get("update")


@pytest.mark.parametrize("method", ASKED)
def test_a_method_is_run_as_its_family_is_and_only_coefficients_make_a_structure(
    store: SqlStore, method: str
) -> None:
    found, (kind, _) = updated(store, "update_and_store", method), ASKED[method]
    assert isinstance(found, kind)
    inputs = dict(store.updates.entry("update").inputs)
    made = {entry.id for entry in store.structures.list(owner="me", limit=9)} - {"model"}
    assert made == ({inputs.pop("updated_structure_id")} if kind is UpdateResult else set())
    assert inputs == {"structure_id": "model", "modal_model_id": "modes"}

"""Long work by name: compute and store.

Each task is a module-level function of JSON values, so that any engine can carry it to a worker,
which brings the store. It may stop inside `progress`, which raises `CancelledError`; nothing is
stored then. It may run twice: the id of what it makes is given, and stored once.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from modallab.core.dof import Dof
from modallab.core.place import EffectSpec
from modallab.core.progress import Progress
from modallab.diagnosis.diagnose import diagnose
from modallab.estimation.windows import WINDOWS, added_loss_factor
from modallab.extraction.extract import extract
from modallab.extraction.leakage import Leakage
from modallab.extraction.window_damping import without_added
from modallab.rig.effect import build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from modallab.store.base import Store, Truth
from modallab.store.plain import from_plain
from modallab.updating.method import UPDATERS, UpdateOptions
from modallab.updating.parameterisation import Parameterisation

Json = Any


@dataclass(frozen=True)
class Destination:
    """Where a task's result goes: whose it is, and its id, fixed when the job was submitted."""

    owner: str
    id: str

    def beside(self, name: str) -> str:
        """Return the id of something else the task makes, the same however often it runs."""
        return hashlib.sha256(f"{self.id}/{name}".encode()).hexdigest()[:24]


# The same numbers in another order round otherwise: to the byte, a measurement is theirs too.
_LIBRARIES = {"numpy": np.__version__, "scipy": scipy.__version__}


def measure_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    rig_id: str,
    effects: Json,
    route: str,
    seed: int,
) -> None:
    """Run the virtual test; keep the measurement, and apart from it how it was made."""
    structure, setup = store.structures.get(structure_id), store.rigs.get(rig_id)
    specs = from_plain(tuple[EffectSpec, ...], effects, {})
    measurement = measure(
        structure,
        setup,
        [build(spec) for spec in specs],
        route=Route(route),
        rng=np.random.default_rng(seed),
        progress=progress,
    )
    with store.together() as batch:
        batch.measurements.add(
            replace(measurement, seed=seed, route=route, libraries=_LIBRARIES),
            owner=into.owner,
            inputs={"rig_id": rig_id},
            seed=seed,
            id=into.id,
        )
        truth = Truth(structure_id, specs)
        batch.truths.add(truth, measurement_id=into.id, owner=into.owner)


_PERIODIC = 0.0  # share of the power that leaks, of an excitation that repeats with the record
_WINDOW_SAMPLES = 1024


def _leakage(setup: RigSetup) -> Leakage | None:
    analyser = setup.analyser
    if EXCITATIONS[analyser.excitation.kind].continuous == _PERIODIC:
        return None
    window = WINDOWS[analyser.window].samples(_WINDOW_SAMPLES)
    return Leakage.of(window, analyser.estimator, source_mass=setup.exciter.armature_mass)


def extract_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    measurement_id: str,
    method: str,
    bands: list[tuple[float, float]] | None,
    n_modes: int | None,
    correct_window_damping: bool = False,
) -> None:
    """Read the modes from a measurement and keep them."""
    measurement = store.measurements.get(measurement_id)
    model = extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=method,
        bands=bands,
        n_modes=n_modes,
        leakage=_leakage(measurement.setup),
        progress=progress,
    )
    analyser = measurement.setup.analyser
    if correct_window_damping and analyser.line_window.end < 1:
        end = analyser.line_window.end
        model = without_added(model, added_loss_factor(end, analyser.record_length, model.frequencies))
    store.modal_models.add(model, owner=into.owner, inputs={"measurement_id": measurement_id}, id=into.id)


def update_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    modal_model_id: str,
    method: str,
    parameterisation: Json,
    options: Json,
) -> None:
    """Correct a model by measured modes; keep how it went, and the updated model beside it."""
    structure, target = store.structures.get(structure_id), store.modal_models.get(modal_model_id)
    result = UPDATERS[method](
        structure,
        from_plain(Parameterisation, parameterisation, {}),
        target,
        options=from_plain(UpdateOptions, options, {}),
        progress=progress,
    )
    made_from = {"structure_id": structure_id, "modal_model_id": modal_model_id}
    updated_id = into.beside("structure")
    with store.together() as batch:
        batch.structures.add(result.structure, owner=into.owner, inputs=made_from, id=updated_id)
        inputs = made_from | {"updated_structure_id": updated_id}
        batch.updates.add(result, owner=into.owner, inputs=inputs, id=into.id)


def diagnose_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    measurement_id: str,
    suspects: list[str] | None,
    hold_out_fraction: float,
    hold_out: list[str],
    max_effects: int,
    seed: int,
) -> None:
    """Find what a model lacks; keep the findings, and beside them model and rig with what was added.

    Reads the model, and the measurement as anyone may read it: not its truth.
    """
    structure, measurement = store.structures.get(structure_id), store.measurements.get(measurement_id)
    found = diagnose(
        structure,
        measurement,
        suspects=suspects,
        hold_out_fraction=hold_out_fraction,
        hold_out=[Dof.parse(text) for text in hold_out],
        max_effects=max_effects,
        seed=seed,
        progress=progress,
    )
    made_from = {"structure_id": structure_id, "measurement_id": measurement_id}
    extended = {"extended_structure_id": into.beside("structure"), "extended_rig_id": into.beside("rig")}
    with store.together() as batch:
        batch.structures.add(
            found.structure, owner=into.owner, inputs=made_from, id=extended["extended_structure_id"]
        )
        batch.rigs.add(found.setup, owner=into.owner, inputs=made_from, id=extended["extended_rig_id"])
        batch.diagnoses.add(found, owner=into.owner, inputs=made_from | extended, seed=seed, id=into.id)


Task = Callable[..., None]
TASKS: Mapping[str, Task] = {
    "measure_and_store": measure_and_store,
    "extract_and_store": extract_and_store,
    "update_and_store": update_and_store,
    "diagnose_and_store": diagnose_and_store,
}

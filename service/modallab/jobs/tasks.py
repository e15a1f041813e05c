"""Long work by name: compute and store.

Each task is a module-level function of JSON values, so that any engine can carry it to a worker,
which brings the store. It may stop inside `progress`, which raises `CancelledError`; nothing is
stored then. It may run twice: the id of what it makes is given, and stored once.
"""

from collections.abc import Callable, Mapping
from typing import Any

from modallab.core.progress import Progress
from modallab.estimation.windows import WINDOWS, added_loss_factor
from modallab.extraction.extract import extract
from modallab.extraction.leakage import Leakage
from modallab.extraction.window_damping import without_added
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import diagnose_and_store
from modallab.jobs.measuring import measure_and_store
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.method import UPDATERS, UpdateOptions
from modallab.updating.parameterisation import Parameterisation

Json = Any


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


Task = Callable[..., None]
TASKS: Mapping[str, Task] = {
    "measure_and_store": measure_and_store,
    "extract_and_store": extract_and_store,
    "update_and_store": update_and_store,
    "diagnose_and_store": diagnose_and_store,
}

"""Models corrected, or searched for errors, by measured modes or frequency responses."""

from typing import Any

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress
from modallab.fe.structure import Structure
from modallab.jobs.destination import Destination
from modallab.rig.exact import as_modelled, with_effects
from modallab.rig.measurement import Measurement
from modallab.rig.noise_bias import without_noise_bias
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.direct.method import DIRECT_METHODS, DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.direct.run import update_directly
from modallab.updating.error_location.method import LOCATORS, LocationResult
from modallab.updating.error_location.run import locate
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import LocationOptions, UpdateOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.responses.method import RESPONSE_UPDATERS
from modallab.updating.responses.target import TargetResponses, target_responses

Json = Any


def update_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    method: str,
    options: Json,
    modal_model_id: str | None = None,
    measurement_id: str | None = None,
    noise_floor: float | None = None,
    parameterisation: Json = None,
) -> None:
    """Run an updating method of any family; keep what it found, and the updated model if it makes one.

    Matrices of a direct method are no structure, and what only locates errors leaves the model as it is.
    """
    structure = store.structures.get(structure_id)
    target: ModalModel | TargetResponses
    if measurement_id is not None:
        target = measured_responses(store.measurements.get(measurement_id), noise_floor)
        inputs = {"structure_id": structure_id, "measurement_id": measurement_id}
    else:
        target = store.modal_models.get(str(modal_model_id))
        inputs = {"structure_id": structure_id, "modal_model_id": str(modal_model_id)}
    result = _run_method(structure, target, method, options, parameterisation, progress)
    with store.together() as batch:
        if isinstance(result, UpdateResult):
            updated_id = into.beside("structure")
            batch.structures.add(result.structure, owner=into.owner, inputs=inputs, id=updated_id)
            inputs = inputs | {"updated_structure_id": updated_id}
        batch.updates.add(result, owner=into.owner, inputs=inputs, id=into.id)


def measured_responses(measurement: Measurement, noise_floor: float | None) -> TargetResponses:
    """Return measured FRFs with their random errors; `InvalidInputError` if these are not known."""
    frf, common = without_noise_bias(measurement)
    return target_responses(frf, measurement.coherence, measurement.averages, noise_floor, common)


def _run_method(
    structure: Structure,
    target: ModalModel | TargetResponses,
    method: str,
    options: Json,
    parameterisation: Json,
    progress: Progress,
) -> UpdateResult | DirectResult | LocationResult:
    if isinstance(target, TargetResponses):
        return RESPONSE_UPDATERS[method](
            with_effects(structure),
            from_plain(Parameterisation, parameterisation, {}),
            target,
            options=from_plain(UpdateOptions, options, {}),
            progress=progress,
        )
    if method in DIRECT_METHODS:
        return update_directly(
            as_modelled(structure),
            method,
            target,
            options=from_plain(DirectOptions, options, {}),
            progress=progress,
        )
    structure = with_effects(structure)
    may_move = from_plain(Parameterisation, parameterisation, {})
    if method in LOCATORS:
        chosen = from_plain(LocationOptions, options, {})
        return locate(structure, may_move, method, target, options=chosen, progress=progress)
    tuned = from_plain(UpdateOptions, options, {})
    return UPDATERS[method](structure, may_move, target, options=tuned, progress=progress)

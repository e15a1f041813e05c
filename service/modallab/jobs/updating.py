"""Models corrected, or searched for errors, by measured modes."""

from typing import Any

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress
from modallab.fe.structure import Structure
from modallab.jobs.destination import Destination
from modallab.rig.exact import as_modelled, with_effects
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.direct.method import DIRECT_METHODS, DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.direct.run import update_directly
from modallab.updating.locating.method import LOCATORS, LocationResult
from modallab.updating.locating.run import LocationOptions, locate
from modallab.updating.method import UPDATERS, UpdateOptions, UpdateResult
from modallab.updating.parameterisation import Parameterisation

Json = Any


def update_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    modal_model_id: str,
    method: str,
    options: Json,
    parameterisation: Json = None,
) -> None:
    """Run an updating method of any family; keep what it found, and the updated model if it makes one.

    Matrices of a direct method are no structure, and what only locates errors leaves the model as it is.
    """
    structure, target = store.structures.get(structure_id), store.modal_models.get(modal_model_id)
    result = _found(structure, target, method, options, parameterisation, progress)
    inputs = {"structure_id": structure_id, "modal_model_id": modal_model_id}
    with store.together() as batch:
        if isinstance(result, UpdateResult):
            updated_id = into.beside("structure")
            batch.structures.add(result.structure, owner=into.owner, inputs=inputs, id=updated_id)
            inputs = inputs | {"updated_structure_id": updated_id}
        batch.updates.add(result, owner=into.owner, inputs=inputs, id=into.id)


def _found(
    structure: Structure,
    target: ModalModel,
    method: str,
    options: Json,
    parameterisation: Json,
    progress: Progress,
) -> UpdateResult | DirectResult | LocationResult:
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

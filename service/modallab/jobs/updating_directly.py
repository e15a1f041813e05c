"""A model's matrices corrected, or searched for errors, by measured modes."""

from typing import Any

from modallab.core.progress import Progress
from modallab.jobs.destination import Destination
from modallab.rig.exact import as_modelled
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.direct.method import DirectOptions
from modallab.updating.direct.run import update_directly

Json = Any


def update_directly_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    modal_model_id: str,
    method: str,
    options: Json,
) -> None:
    """Run a direct method and keep what it found; matrices are no structure, so none is made."""
    result = update_directly(
        as_modelled(store.structures.get(structure_id)),
        method,
        store.modal_models.get(modal_model_id),
        options=from_plain(DirectOptions, options, {}),
        progress=progress,
    )
    inputs = {"structure_id": structure_id, "modal_model_id": modal_model_id}
    store.updates.add(result, owner=into.owner, inputs=inputs, id=into.id)

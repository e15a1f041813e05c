"""Members that measured modes speak against, found by one linear step."""

from typing import Any

from modallab.core.progress import Progress
from modallab.jobs.destination import Destination
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.locating.run import LocationOptions, locate
from modallab.updating.parameterisation import Parameterisation

Json = Any


def locate_and_store(
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
    """Locate errors and keep what was found; the model stays as it is."""
    result = locate(
        store.structures.get(structure_id),
        from_plain(Parameterisation, parameterisation, {}),
        method,
        store.modal_models.get(modal_model_id),
        options=from_plain(LocationOptions, options, {}),
        progress=progress,
    )
    inputs = {"structure_id": structure_id, "modal_model_id": modal_model_id}
    store.updates.add(result, owner=into.owner, inputs=inputs, id=into.id)

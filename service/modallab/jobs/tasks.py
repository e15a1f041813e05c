"""Long work by name: compute and store.

Each task is a module-level function of JSON values, so that any engine can carry it to a worker,
which brings the store. It may stop inside `progress`, which raises `CancelledError`; nothing is
stored then. It may run twice: the id of what it makes is given, and stored once.
"""

from collections.abc import Callable, Mapping
from typing import Any

from modallab.core.progress import Progress
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import diagnose_and_store
from modallab.jobs.extracting import extract_and_store
from modallab.jobs.locating import locate_and_store
from modallab.jobs.measuring import measure_and_store
from modallab.jobs.updating_directly import update_directly_and_store
from modallab.store.base import Store
from modallab.store.plain import from_plain
from modallab.updating.method import UPDATERS, UpdateOptions
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
    "update_directly_and_store": update_directly_and_store,
    "locate_and_store": locate_and_store,
    "diagnose_and_store": diagnose_and_store,
}

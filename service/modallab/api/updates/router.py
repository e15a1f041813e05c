"""Updates: models corrected by measured modes."""

from typing import Annotated

from fastapi import APIRouter, status

from modallab.api.deps import IdPath, JobsDep, OwnerDep, StoreDep
from modallab.api.examples import example
from modallab.api.jobs import JobOut
from modallab.api.shelves import add_routes
from modallab.api.updates.schemas import UpdateOut, UpdateStart

router = APIRouter(prefix="/updates", tags=["updates"])

_BODY = {
    "structure_id": "5f0c31",
    "modal_model_id": "77ab10",
    "method": "inverse_eigensensitivity",
    "parameterisation": {"macros": [[1, 2, 3, 4], [5, 6, 7, 8]], "parts": ["mass", "stiffness"]},
    "options": {"max_iterations": 30},
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, summary="Correct a model by measured modes")
def start_update(
    body: Annotated[UpdateStart, example(_BODY)], store: StoreDep, jobs: JobsDep, owner: OwnerDep
) -> JobOut:
    store.modal_models.check(body.modal_model_id)
    arguments = body.to_arguments(store.structures.get(body.structure_id))
    return JobOut.of(jobs.submit("update_and_store", arguments, owner=owner))


@router.get("/{id}", summary="How an update went")
def get_update(id: IdPath, store: StoreDep) -> UpdateOut:
    return UpdateOut.of(store.updates.get(id), store.updates.entry(id))


add_routes(router, "updates")

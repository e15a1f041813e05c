"""Modal models: read from measurements, or imported."""

from typing import Annotated

from fastapi import APIRouter, status
from starlette.responses import Response

from modallab.api.arrays import NPZ, Precision, npz_reply
from modallab.api.deps import IdPath, JobsDep, OwnerDep, StoreDep
from modallab.api.examples import example
from modallab.api.jobs import JobOut
from modallab.api.modal_models.schemas import ModalModelIn, ModalModelOut, ModalModelStart
from modallab.api.shelves import add_routes
from modallab.extraction.method import EXTRACTION_METHODS

router = APIRouter(prefix="/modal-models", tags=["modal models"])

_START = {"measurement_id": "c04d1a", "method": "dobson", "bands": "auto", "n_modes": 8}
_IMPORT = {
    "modes": [{"frequency": 23.6, "loss_factor": 0.01, "shape": [1.15, [-0.7, 0.01], 1.15]}],
    "dofs": ["1:+Y", "11:+Y", "21:+Y"],
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, summary="Read modes from a measurement")
def start_modal_model(
    body: Annotated[ModalModelStart, example(_START)], store: StoreDep, jobs: JobsDep, owner: OwnerDep
) -> JobOut:
    store.measurements.check(body.measurement_id)
    EXTRACTION_METHODS[body.method]  # an unknown name is refused now, not in a failed job later
    arguments = body.model_dump(mode="json") | {"bands": None if body.bands == "auto" else body.bands}
    return JobOut.of(jobs.submit("extract_and_store", arguments, owner=owner))


@router.post("/import", status_code=status.HTTP_201_CREATED, summary="Import modes from elsewhere")
def import_modal_model(
    body: Annotated[ModalModelIn, example(_IMPORT)], store: StoreDep, owner: OwnerDep
) -> ModalModelOut:
    model = body.to_domain()
    return ModalModelOut.of(model, store.modal_models.entry(store.modal_models.add(model, owner=owner)))


@router.get("/{id}", summary="Modes without their shapes")
def get_modal_model(id: IdPath, store: StoreDep) -> ModalModelOut:
    return ModalModelOut.of(store.modal_models.get(id), store.modal_models.entry(id))


@router.get(
    "/{id}/arrays", response_class=Response, responses=NPZ, summary="Shapes, constants of each FRF: npz"
)
def get_modal_model_arrays(id: IdPath, store: StoreDep, precision: Precision = "double") -> Response:
    return npz_reply(store.modal_models.npz(id), precision)


add_routes(router, "modal_models")

"""Correlations: measured modes against those of a model."""

from typing import Annotated

from fastapi import APIRouter, status

from modallab.api.correlations.schemas import CorrelationIn, CorrelationOut
from modallab.api.deps import IdPath, OwnerDep, StoreDep
from modallab.api.examples import example
from modallab.api.shelves import add_routes
from modallab.correlation.compare import compare
from modallab.fe.selected import exact_modes
from modallab.rig.exact import as_modelled

router = APIRouter(prefix="/correlations", tags=["correlations"])

_BODY = {"modal_model_id": "77ab10", "structure_id": "5f0c31"}


@router.post("", status_code=status.HTTP_201_CREATED, summary="Compare measured modes with a model's")
def create_correlation(
    body: Annotated[CorrelationIn, example(_BODY)], store: StoreDep, owner: OwnerDep
) -> CorrelationOut:
    measured = store.modal_models.get(body.modal_model_id)
    system = as_modelled(store.structures.get(body.structure_id))
    model = exact_modes(system, body.count or min(len(measured.modes), 100))
    found = compare(model, measured)
    inputs = {"modal_model_id": body.modal_model_id, "structure_id": body.structure_id}
    stored = store.correlations.add(found, owner=owner, inputs=inputs)
    return CorrelationOut.of(found, store.correlations.entry(stored))


@router.get("/{id}", summary="A correlation")
def get_correlation(id: IdPath, store: StoreDep) -> CorrelationOut:
    return CorrelationOut.of(store.correlations.get(id), store.correlations.entry(id))


add_routes(router, "correlations")

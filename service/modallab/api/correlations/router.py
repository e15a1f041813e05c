"""Correlations: measured modes, and measured FRFs, against those of a model."""

from typing import Annotated, Any

from fastapi import APIRouter, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.assignments.seal import check_may_diagnose
from modallab.api.correlations.replies import CorrelationReply, correlation_arrays, correlation_reply
from modallab.api.correlations.schemas import CorrelationIn
from modallab.api.deps import IdPath, StoreDep, ViewerDep
from modallab.api.examples import examples
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.reductions import check_size, reduction_in
from modallab.api.shelves import add_routes
from modallab.correlation.compare import correlate
from modallab.rig.exact import as_modelled

router = APIRouter(prefix="/correlations", tags=["correlations"], route_class=OffloadedRoute)

_IDS = {"modal_model_id": "77ab10", "structure_id": "5f0c31"}
_BODY = examples(
    modes=_IDS,
    mass=_IDS | {"reduction": "serep"},
    everything=_IDS
    | {
        "measurement_id": "c04d1a",
        "reduction": {"kind": "dynamic", "parameters": {"frequency": 60.0}},
    },
)


@router.post(
    "", status_code=status.HTTP_201_CREATED, response_model=CorrelationReply, summary="Create a correlation"
)
def create_correlation(body: Annotated[CorrelationIn, _BODY], store: StoreDep, viewer: ViewerDep) -> Any:
    """Return the correlation of measured modes, and of measured FRFs if given, with a structure."""
    if body.measurement_id is not None:
        check_may_diagnose(store, viewer, [body.measurement_id])
    reduction = None if body.reduction is None else reduction_in(body.reduction)
    system = as_modelled(store.structures.get(body.structure_id))
    measured = store.modal_models.get(body.modal_model_id)
    if reduction is not None:
        check_size(system, len(measured.dofs), "reduction")
    correlation = correlate(
        system,
        measured,
        count=body.count,
        reduction=reduction,
        frf=None
        if body.measurement_id is None
        else body.lines_of(store.measurements.get(body.measurement_id).frf),
    )
    stored = store.correlations.add(correlation, owner=viewer.owner, inputs=body.inputs)
    return correlation_reply(correlation, store.correlations.entry(stored))


@router.get("/{id}", response_model=CorrelationReply, summary="Get a correlation")
def get_correlation(id: IdPath, store: StoreDep) -> Any:
    """Return a stored correlation."""
    return correlation_reply(store.correlations.get(id), store.correlations.entry(id))


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.CORRELATION,
    summary="Get the matrices of a correlation",
)
def get_correlation_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return all matrices of a correlation, with the frequency domain assurance criterion."""
    return form.reply(correlation_arrays(store.correlations.get(id)))


add_routes(router, "correlations", "correlation")

"""Modal models: read from measurements, or imported."""

from typing import Annotated, Any

from fastapi import APIRouter, File, UploadFile, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.deps import IdPath, JobsDep, OwnerDep, RequestKeyDep, SettingsDep, StoreDep
from modallab.api.examples import example
from modallab.api.files import FILE, UFF, FormRoute, origin, uff_reply
from modallab.api.jobs import JobReply, job_reply
from modallab.api.kinds import KindWanted, measured_as
from modallab.api.media import CsvWanted, csv_or, csv_replies
from modallab.api.modal_models.fits import (
    MODE,
    REFERENCE,
    RESPONSE,
    ChartReply,
    FitReply,
    chart_reply,
    fit_reply,
    frf_arrays,
    measured_for,
)
from modallab.api.modal_models.reciprocal import (
    OTHER,
    ModalReciprocityCheck,
    ModalReciprocityReply,
    modal_reciprocity_of,
)
from modallab.api.modal_models.replies import DETAILS, ModalModelReply, modal_model_reply
from modallab.api.modal_models.schemas import ModalModelIn, ModalModelStart, SelectionIn
from modallab.api.modal_models.table import COLUMNS, mode_rows
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.shelves import add_routes
from modallab.api.thinning import Points
from modallab.core.dof import Dof
from modallab.core.line_options import line_mask
from modallab.core.modal_model import ModalModel
from modallab.interchange import uff_modes
from modallab.interchange.reading import read_modal_model
from modallab.jobs.durations import duration_of_extraction
from modallab.jobs.extracting import picture_of, resynthesised
from modallab.jobs.selecting import selected_model
from modallab.jobs.tasks import EXTRACTION
from modallab.store.base import Store

router = APIRouter(prefix="/modal-models", tags=["modal_models"], route_class=OffloadedRoute)

_START = {
    "measurement_id": "c04d1a",
    "method": "dobson",
    "bands": "auto",
    "n_modes": 8,
    "options": {"lines": 12, "leave_out": 2},
}
_SELECTION = {"drop": [2, 5], "merge": [[3, 4]]}
_IMPORT = {
    "modes": [{"frequency": 23.6, "loss_factor": 0.01, "shape": [1.15, [-0.7, 0.01], 1.15]}],
    "dofs": ["1:+Y", "11:+Y", "21:+Y"],
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, response_model=JobReply, summary="Start an extraction")
def start_modal_model(
    body: Annotated[ModalModelStart, example(_START)],
    store: StoreDep,
    jobs: JobsDep,
    owner: OwnerDep,
    request_key: RequestKeyDep,
) -> Any:
    """Start a job that extracts modes from a measurement."""
    store.measurements.check(body.measurement_id)
    inputs, request = body.to_task()
    if request.bands is not None or request.exclude:
        # Bands beyond the test are refused here: the job could only fail.
        freq = store.measurements.get(body.measurement_id).frf.freq
        line_mask(freq, request.bands, request.exclude)
    lane = duration_of_extraction(store.weight([body.measurement_id], 1.0, origins=False)).lane
    arguments = EXTRACTION.arguments(inputs, request)
    return job_reply(jobs.submit(EXTRACTION.name, arguments, owner=owner, lane=lane, request=request_key))


def _stored(model: ModalModel, store: Store, owner: str) -> Any:
    return modal_model_reply(model, store.modal_models.entry(store.modal_models.add(model, owner=owner)))


def import_modal_file(
    file: Annotated[UploadFile, File(description="universal file, dataset 55")],
    store: StoreDep,
    settings: SettingsDep,
    owner: OwnerDep,
) -> Any:
    """Return the modal model of a universal file (dataset 55)."""
    return _stored(read_modal_model(file.file, largest=settings.upload_limit), store, owner)


# Out of the document, where a path has one POST: the route below tells of both.
router.add_api_route(
    "/import",
    import_modal_file,
    methods=["POST"],
    status_code=status.HTTP_201_CREATED,
    include_in_schema=False,
    route_class_override=FormRoute,
)


@router.post(
    "/import",
    status_code=status.HTTP_201_CREATED,
    response_model=ModalModelReply,
    summary="Import modes",
    openapi_extra=FILE,
)
def import_modal_model(
    body: Annotated[ModalModelIn, example(_IMPORT)], store: StoreDep, owner: OwnerDep
) -> Any:
    """Return a modal model from frequencies, loss factors and shapes as JSON, or a universal file."""
    return _stored(body.to_domain(), store, owner)


@router.post(
    "/{id}/select",
    status_code=status.HTTP_201_CREATED,
    response_model=ModalModelReply,
    summary="Drop or merge modes",
)
def select_from_modal_model(
    id: IdPath, body: Annotated[SelectionIn, example(_SELECTION)], store: StoreDep, owner: OwnerDep
) -> Any:
    """Return a new modal model without the dropped modes, and with one mode for each group of merged modes.

    Nothing is extracted again. Frequency and loss factor of a merged mode are means weighted by inverse
    variance, its modal constants are the sums, and its shape follows from these; residuals and misfit are
    fitted to the FRFs of the measurement. Shapes without modal constants are averaged.
    """
    model, made_from = store.modal_models.get(id), store.modal_models.entry(id).inputs
    measurement_id = made_from.get("measurement_id")
    measurement = None if measurement_id is None else store.measurements.get(measurement_id)
    selected = selected_model(model, body.to_domain(), measurement)
    stored = store.modal_models.add(selected, owner=owner, inputs={**made_from, "modal_model_id": id})
    return modal_model_reply(selected, store.modal_models.entry(stored))


@router.get(
    "/{id}",
    summary="Get modes",
    response_model=ModalModelReply,
    responses=csv_replies(COLUMNS),
)
def get_modal_model(id: IdPath, store: StoreDep, as_csv: CsvWanted, details: DETAILS) -> Any:
    """Return the modes of a modal model without their shapes."""
    model = store.modal_models.get(id)
    entry = store.modal_models.entry(id)
    return csv_or(
        lambda: modal_model_reply(model, entry, details=details),
        COLUMNS,
        mode_rows(model, details),
        as_csv=as_csv,
    )


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.MODAL_MODEL,
    summary="Get shapes and modal constants",
)
def get_modal_model_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return the mode shapes of a modal model, and the modal constants of each FRF."""
    return form.reply_npz(store.modal_models.npz(id))


@router.get("/{id}/fits", response_model=FitReply, summary="Get the fit of a mode")
def get_fit(id: IdPath, store: StoreDep, mode: MODE, response: RESPONSE, reference: REFERENCE = None) -> Any:
    """Return the fit of one mode in one FRF, to be drawn: lines, curve, and the data of the method."""
    model, at = store.modal_models.get(id), Dof.parse(response, field="response")
    of = None if reference is None else Dof.parse(reference, field="reference")
    return fit_reply(picture_of(measured_for(id, model, store), model, mode, at, of), mode, at, of)


@router.get("/{id}/chart", response_model=ChartReply, summary="Get the stabilisation chart")
def get_chart(id: IdPath, store: StoreDep, points: Points = 800) -> Any:
    """Return the stabilisation chart of a global extraction method, with mode indicator functions."""
    model = store.modal_models.get(id)
    return chart_reply(model, measured_for(id, model, store), points)


@router.get(
    "/{id}/frf",
    response_class=Response,
    responses=array_tables.FRFS,
    summary="Synthesise FRFs",
)
def get_resynthesised(
    id: IdPath, store: StoreDep, form: ArraysFormatDep, kind: KindWanted = None
) -> Response:
    """Return FRFs synthesised from a modal model at the lines of its measurement."""
    model = store.modal_models.get(id)
    measurement = measured_as(kind, measured_for(id, model, store))
    return form.reply(frf_arrays(resynthesised(measurement, model)))


@router.get(
    "/{id}/reciprocity", response_model=ModalReciprocityReply, summary="Check reciprocity of modal constants"
)
def get_modal_reciprocity(id: IdPath, store: StoreDep, other: OTHER) -> ModalReciprocityCheck:
    """Return ratios of modal constants to those of a test driven at the response."""
    return modal_reciprocity_of(store.modal_models.get(id), store.modal_models.get(other))


@router.get(
    "/{id}/modes.uff", response_class=Response, responses=UFF, summary="Get modes as a universal file"
)
def get_modal_model_uff(id: IdPath, store: StoreDep) -> Response:
    """Return the modes of a modal model as a universal file (dataset 55)."""
    content = origin(store.modal_models.entry(id), "modal model")
    return uff_reply(uff_modes.write(store.modal_models.get(id), content), id)


add_routes(router, "modal_models", "modal_model")

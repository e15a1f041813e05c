"""Updates: models corrected by measured modes or frequency responses."""

from typing import Annotated, Any

from fastapi import APIRouter, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.assignments.seal import check_may_diagnose
from modallab.api.deps import IdPath, JobsDep, RequestKeyDep, SettingsDep, StoreDep, ViewerDep
from modallab.api.examples import examples
from modallab.api.jobs import JobReply, job_reply
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.shelves import add_routes
from modallab.api.updates.arrays import covariance_arrays, direct_arrays, posterior_arrays
from modallab.api.updates.replies import UpdateReply, update_reply
from modallab.api.updates.responses import check_responses
from modallab.api.updates.schemas import UpdateStart
from modallab.core.errors import NotFoundError
from modallab.jobs.durations import duration_of_solutions
from modallab.jobs.tasks import UPDATE
from modallab.rig.exact import with_effects
from modallab.updating.direct.result import DirectResult
from modallab.updating.method import UpdateResult

router = APIRouter(prefix="/updates", tags=["updates"], route_class=OffloadedRoute)

_BODY = {
    "structure_id": "5f0c31",
    "modal_model_id": "77ab10",
    "method": "inverse_eigensensitivity",
    "parameterisation": {"macros": [[1, 2, 3, 4], [5, 6, 7, 8]], "parts": ["mass", "stiffness"]},
    "options": {"max_iterations": 30},
}
_AT_ONCE = {
    "structure_id": "5f0c31",
    "modal_model_id": "77ab10",
    "method": "one_shot",
    "parameterisation": {"macros": [[1], [2], [3], [4]], "parts": ["mass", "stiffness"]},
    "options": {"prior": "sparse", "underdetermined": "regularised"},
}
_RESPONSES = {
    "structure_id": "5f0c31",
    "measurement_id": "c04d1a",
    "method": "frf_residual",
    "parameterisation": {"macros": "each", "parts": ["mass", "stiffness"]},
}
_DIRECT = {
    "structure_id": "5f0c31",
    "modal_model_id": "77ab10",
    "method": "berman_nagy",
    "options": {"completion": "expansion", "expansion": "serep", "n_modes": 5},
}
_BODIES = {"coefficients": _BODY, "at_once": _AT_ONCE, "responses": _RESPONSES, "matrices": _DIRECT}


@router.post("", status_code=status.HTTP_202_ACCEPTED, response_model=JobReply, summary="Start an update")
def start_update(
    body: Annotated[
        UpdateStart, examples(coefficients=_BODY, at_once=_AT_ONCE, responses=_RESPONSES, matrices=_DIRECT)
    ],
    store: StoreDep,
    jobs: JobsDep,
    viewer: ViewerDep,
    request_key: RequestKeyDep,
    settings: SettingsDep,
) -> Any:
    """Start a job that corrects a structure from measured modes or FRFs."""
    structure = with_effects(store.structures.get(body.structure_id))
    inputs, request = body.to_task(structure)
    n = getattr(request.options, "max_iterations", 1)
    duration = duration_of_solutions(len(structure.dofs), n, "max_iterations", n)
    duration.check(settings.job_seconds)
    arguments = UPDATE.arguments(inputs, request)
    if body.modal_model_id is not None:
        store.modal_models.check(body.modal_model_id)
    if body.measurement_id is not None:
        check_may_diagnose(store, viewer, [body.measurement_id])
        measurement = store.measurements.get(body.measurement_id)
        check_responses(structure, measurement, body.noise_floor, body.lines)
    return job_reply(
        jobs.submit(UPDATE.name, arguments, owner=viewer.owner, lane=duration.lane, request=request_key)
    )


@router.get("/{id}", response_model=UpdateReply, summary="Get an update")
def get_update(id: IdPath, store: StoreDep) -> Any:
    """Return the result of an update: coefficients, standard errors, frequencies before and after."""
    return update_reply(store.updates.get(id), store.updates.entry(id))


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.UPDATED_MATRICES,
    summary="Get updated matrices",
)
def get_update_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return the updated matrices of a direct updating method."""
    result = store.updates.get(id)
    if not isinstance(result, DirectResult):
        raise NotFoundError("this update has coefficients of members, and no matrices", field="id", value=id)
    return form.reply(direct_arrays(result))


@router.get(
    "/{id}/covariance",
    response_class=Response,
    responses=array_tables.COVARIANCE,
    summary="Get the covariance of coefficients",
)
def get_update_covariance(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return the covariance of updated coefficients."""
    result = store.updates.get(id)
    if not isinstance(result, UpdateResult) or result.identifiability is None:
        raise NotFoundError("this update has no coefficients that were free to move", field="id", value=id)
    return form.reply(covariance_arrays(result.identifiability))


@router.get(
    "/{id}/sample",
    response_class=Response,
    responses=array_tables.POSTERIOR,
    summary="Get draws from the posterior",
)
def get_update_sample(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return draws from the posterior of updated coefficients."""
    result = store.updates.get(id)
    if not isinstance(result, UpdateResult) or result.posterior is None:
        raise NotFoundError("this update has no draws: `samples` asks for them", field="id", value=id)
    return form.reply(posterior_arrays(result.posterior))


add_routes(router, "updates", "update")

"""Studies: how surely an updating method finds known errors from noisy modes."""

from typing import Annotated, Any

from fastapi import APIRouter, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.deps import IdPath, JobsDep, OwnerDep, RequestKeyDep, SettingsDep, StoreDep
from modallab.api.examples import example
from modallab.api.jobs import JobReply, job_reply
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.shelves import add_routes
from modallab.api.studies.replies import StudyReply, study_arrays, study_reply
from modallab.api.studies.schemas import StudyStart
from modallab.jobs.durations import duration_of_solutions
from modallab.jobs.tasks import STUDY
from modallab.rig.exact import with_effects

router = APIRouter(prefix="/studies", tags=["studies"], route_class=OffloadedRoute)

_BODY = {
    "structure_id": "5f0c31",
    "truth_id": "77ab10",
    "method": "inverse_eigensensitivity",
    "divisions": {"fours": [[1, 2, 3, 4], [5, 6, 7, 8]], "auto": "auto"},
    "levels": ["NL1", "NL3", {"name": "shapes only", "eigenvector": 0.05}],
    "seeds": [1, 2, 3],
    "count": 10,
    "dofs": ["1:+Y", "3:+Y", "5:+Y"],
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, response_model=JobReply, summary="Start a study")
def start_study(
    body: Annotated[StudyStart, example(_BODY)],
    store: StoreDep,
    jobs: JobsDep,
    owner: OwnerDep,
    request_key: RequestKeyDep,
    settings: SettingsDep,
) -> Any:
    """Start a job that runs an updating method on many sets of noisy modes."""
    model, truth = (with_effects(store.structures.get(id)) for id in (body.structure_id, body.truth_id))
    inputs, plan = body.to_task(model, truth)
    n = plan.n_runs * getattr(plan.options, "max_iterations", 1)
    duration_of_solutions(len(model.dofs), n, "seeds", len(plan.seeds)).check(settings.job_seconds)
    arguments = STUDY.arguments(inputs, plan)
    return job_reply(jobs.submit(STUDY.name, arguments, owner=owner, request=request_key))


@router.get("/{id}", response_model=StudyReply, summary="Get a study")
def get_study(id: IdPath, store: StoreDep) -> Any:
    """Return the statistics of a study by noise level and parameterisation."""
    return study_reply(store.studies.get(id), store.studies.entry(id))


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.STUDY,
    summary="Get the coefficients of all runs",
)
def get_study_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return the coefficients of all runs of a study."""
    return form.reply(study_arrays(store.studies.get(id)))


add_routes(router, "studies", "study")

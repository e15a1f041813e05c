"""Diagnoses: what a model lacks, found from a measurement and its log book."""

from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Query, status
from starlette.responses import HTMLResponse, Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.assignments.seal import check_may_act, check_may_diagnose
from modallab.api.deps import IdPath, JobsDep, OwnerDep, RequestKeyDep, SettingsDep, StoreDep, ViewerDep
from modallab.api.diagnoses.follow_ups import check_follow_ups
from modallab.api.diagnoses.replies import Adoption, DiagnosisReply, diagnosis_reply
from modallab.api.diagnoses.schemas import DiagnosisStart, ReportHeadingQuery
from modallab.api.diagnoses.unknown_arrays import unknown_arrays
from modallab.api.examples import example
from modallab.api.jobs import JobReply, job_reply
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.shelves import add_routes
from modallab.core.errors import InvalidInputError
from modallab.core.line_options import line_mask
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.residuals.random_error import check_random_error_known
from modallab.diagnosis.result_builder import extended
from modallab.diagnosis.unknown.adoption import adopted_effect
from modallab.jobs.durations import DURATION, duration_of_solutions
from modallab.jobs.settings import JOB
from modallab.jobs.tasks import DIAGNOSIS
from modallab.store.npz import pack, unpack

# The page holds all it shows: it may load nothing and run nothing.
_STATIC = {"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:"}

router = APIRouter(prefix="/diagnoses", tags=["diagnoses"], route_class=OffloadedRoute)

_BODY = {
    "structure_id": "5f0c31",
    "measurement_id": "c04d1a",
    "suspects": "all",
    "hold_out": {"fraction": 0.25, "dofs": ["19:+Y"]},
    "follow_ups": [{"measurement_id": "7be902", "changed": {"level_factor": 3.0}}],
    "max_effects": 4,
    "seed": 0,
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, response_model=JobReply, summary="Start a diagnosis")
def start_diagnosis(
    body: Annotated[DiagnosisStart, example(_BODY)],
    store: StoreDep,
    jobs: JobsDep,
    viewer: ViewerDep,
    request_key: RequestKeyDep,
    settings: SettingsDep,
) -> Any:
    """Start a job that searches for the effects that a structure and a rig lack."""
    check_may_diagnose(
        store, viewer, [body.measurement_id, *(test.measurement_id for test in body.follow_ups)]
    )
    if body.act:
        check_may_act(store, viewer, body.measurement_id)
    measurement = store.measurements.get(body.measurement_id)
    structure = store.structures.get(body.structure_id)
    check_comparable(structure, measurement)
    check_random_error_known(replace(measurement, noise_floor=body.noise_floor))
    inputs, options = body.to_task(structure)
    n_tests = 1 + len(inputs.follow_ups) + JOB.further_tests * body.act
    n_dofs = len(structure.dofs)
    n = DURATION.solutions_of_diagnosis * n_tests
    duration_of_solutions(n_dofs, n, "structure_id", n_dofs).check(settings.job_seconds)
    line_mask(measurement.frf.freq, options.bands, options.exclude)
    check_follow_ups(store, structure, body.measurement_id, body.follow_ups, act=body.act)
    arguments = DIAGNOSIS.arguments(inputs, options)
    return job_reply(jobs.submit(DIAGNOSIS.name, arguments, owner=viewer.owner, request=request_key))


@router.get("/{id}", summary="Get a diagnosis", response_model=DiagnosisReply)
def get_diagnosis(id: IdPath, store: StoreDep) -> Any:
    """Return the verdict of a diagnosis and the effects that it names."""
    return diagnosis_reply(store.diagnoses.get(id), store.diagnoses.entry(id))


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.DIAGNOSIS,
    summary="Get measured and predicted FRFs",
)
def get_diagnosis_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return measured FRFs, those predicted before and after a diagnosis, the curve of an unknown effect."""
    payload, diagnosis = store.diagnoses.npz(id), store.diagnoses.get(id)
    if diagnosis.unknown is None:
        return form.reply_npz(payload)
    return form.reply_npz(pack(unpack(payload) | unknown_arrays(diagnosis.unknown, diagnosis.curves.freq)))


@router.get("/{id}/report", response_class=HTMLResponse, summary="Get the report of a diagnosis")
def get_diagnosis_report(
    id: IdPath, store: StoreDep, heading: Annotated[ReportHeadingQuery, Query()]
) -> HTMLResponse:
    """Return the report of a diagnosis as one self-contained HTML page."""
    entry = store.diagnoses.entry(id)
    origin = {**entry.inputs, "id": entry.id, "created": entry.created, "version": entry.version}
    page = report(store.diagnoses.get(id), origin, heading.to_domain())
    return HTMLResponse(page, headers=_STATIC)


@router.post(
    "/{id}/adopt",
    status_code=status.HTTP_201_CREATED,
    response_model=Adoption,
    summary="Adopt an unknown effect",
)
def adopt_unknown_effect(id: IdPath, store: StoreDep, owner: OwnerDep) -> Any:
    """Return a model and a log book with the unknown effect of a diagnosis as a tabulated effect."""
    diagnosis, inputs = store.diagnoses.get(id), store.diagnoses.entry(id).inputs
    if diagnosis.unknown is None:
        raise InvalidInputError(
            "this diagnosis has no unknown effect", field="id", value=id, allowed="a diagnosis with `unknown`"
        )
    structure, setup = diagnosis.structure, diagnosis.setup
    if not diagnosis.unknown.beside_steps:
        structure = store.structures.get(inputs["structure_id"])
        setup = store.measurements.get(inputs["measurement_id"]).setup
    effect = adopted_effect(diagnosis.unknown, diagnosis.curves.freq)
    model, log_book = extended(structure, setup, [effect])
    with store.together() as batch:
        return Adoption(
            structure_id=batch.structures.add(model, owner=owner, inputs={"diagnosis_id": id}),
            rig_id=batch.rigs.add(log_book, owner=owner, inputs={"diagnosis_id": id}),
            kind=effect.kind,
        )


add_routes(router, "diagnoses", "diagnosis")

"""Measurements: made on the virtual rig, or imported."""

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.access import TEACHERS
from modallab.api.arrays import ArraysFormatDep
from modallab.api.deps import IdPath, JobsDep, OwnerDep, RequestKeyDep, SettingsDep, StoreDep
from modallab.api.examples import example
from modallab.api.files import FRF_TEXT, HDF5, UFF, frf_text_reply, hdf5_reply, origin, uff_reply, wav_reply
from modallab.api.jobs import JobReply, job_reply
from modallab.api.kinds import KindWanted, measured_as
from modallab.api.measurements.curves import Curves, curves_of
from modallab.api.measurements.estimates import estimate_arrays
from modallab.api.measurements.import_form import ImportFormDep, UploadedFiles
from modallab.api.measurements.indicators import (
    Indicators,
    IndicatorsReply,
    ReciprocityCheck,
    ReciprocityReply,
    indicators_of,
    reciprocity_of,
)
from modallab.api.measurements.records import (
    RECORD_REPLIES,
    RecordFormat,
    record_arrays,
    records_of,
    wav_file,
)
from modallab.api.measurements.replies import (
    LogReply,
    MeasurementReply,
    TruthReply,
    log_reply,
    measurement_reply,
)
from modallab.api.measurements.schemas import MeasurementStart
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.replies import reply_of
from modallab.api.shelves import add_routes
from modallab.api.thinning import Points
from modallab.interchange import frf_text, hdf5, uff
from modallab.interchange.confinement import NamedFile
from modallab.interchange.reading import read_measurement
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.jobs.durations import duration_of_measurement
from modallab.jobs.tasks import MEASUREMENT
from modallab.rig.effect import build
from modallab.store.base import Truth
from modallab.store.codec import arrays_of, results_alone

router = APIRouter(prefix="/measurements", tags=["measurements"], route_class=OffloadedRoute)
Decimals = Annotated[
    int,
    Query(
        ge=FRF_TEXT_FILE.program_decimals,
        le=FRF_TEXT_FILE.all_decimals,
        description="of every number: 3 keeps to the program's columns, 16 loses nothing",
    ),
]

_TEST = {
    "structure_id": "5f0c31",
    "rig_id": "9b2e77",
    "effects": [{"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": 0.05}}],
    "route": "sampled",
    "seed": 1,
}


@router.post("", status_code=status.HTTP_202_ACCEPTED, response_model=JobReply, summary="Start a measurement")
def start_measurement(
    body: Annotated[MeasurementStart, example(_TEST)],
    store: StoreDep,
    jobs: JobsDep,
    owner: OwnerDep,
    request_key: RequestKeyDep,
    settings: SettingsDep,
) -> Any:
    """Start a job that measures the FRFs of a structure on a rig."""
    structure, setup = store.structures.get(body.structure_id), store.rigs.get(body.rig_id)
    inputs, options = body.to_task(structure, setup)
    effects = [build(spec) for spec in (*structure.effects, *setup.effects, *options.effects)]
    duration = duration_of_measurement(setup, effects, options.route)
    duration.check(settings.job_seconds)
    arguments = MEASUREMENT.arguments(inputs, options)
    return job_reply(
        jobs.submit(MEASUREMENT.name, arguments, owner=owner, lane=duration.lane, request=request_key)
    )


@router.post(
    "/import",
    status_code=status.HTTP_201_CREATED,
    response_model=MeasurementReply,
    summary="Import a measurement",
)
def import_measurement(
    file: UploadedFiles, form: ImportFormDep, store: StoreDep, settings: SettingsDep, owner: OwnerDep
) -> Any:
    """Return a measurement from files of FRFs; their content determines the format.

    Formats: universal file (dataset 58), npz, HDF5, MATLAB, delimited text, FRF text, and a zip of several
    files of one test. Facts that are neither in the files nor declared are assumed, and listed in `assumed`.
    """
    rig_id = form.rig_id
    measurement = read_measurement(
        [NamedFile(part.filename or "", part.file) for part in file],
        None if rig_id is None else store.rigs.get(rig_id),
        largest=settings.upload_limit,
        options=form.options,
        declared=form.declared,
    )
    with store.together() as batch:
        if rig_id is None:
            rig_id = batch.rigs.add(measurement.setup, owner=owner)
        stored = batch.measurements.add(measurement, owner=owner, inputs={"rig_id": rig_id})
    return measurement_reply(measurement, store.measurements.entry(stored))


@router.get("/{id}", response_model=MeasurementReply, summary="Get a measurement")
def get_measurement(id: IdPath, store: StoreDep) -> Any:
    """Return a measurement without its arrays, with its rig as declared."""
    return measurement_reply(store.measurements.get(id), store.measurements.entry(id))


@router.get(
    "/{id}/arrays",
    response_class=Response,
    responses=array_tables.MEASUREMENT,
    summary="Get FRFs, coherence and spectra",
)
def get_measurement_arrays(
    id: IdPath, store: StoreDep, form: ArraysFormatDep, kind: KindWanted = None
) -> Response:
    """Return FRFs, coherence and auto spectra of a measurement."""
    if kind is None:
        return form.reply_npz(results_alone(store.measurements.npz(id)))
    measurement = measured_as(kind, store.measurements.get(id))
    return form.reply(arrays_of(measurement) | {"notes": np.array(measurement.notes, dtype=str)})


@router.get(
    "/{id}/records",
    response_class=Response,
    responses=RECORD_REPLIES,
    summary="Get time records",
)
def get_records(
    id: IdPath, store: StoreDep, form: ArraysFormatDep, file_format: RecordFormat = "npz"
) -> Response:
    """Return the time records that a measurement kept: force and response before the window.

    As `wav` all channels stand side by side, run by run and forces first, and the records one after another.
    """
    measurement = store.measurements.get(id)
    records = records_of(measurement)
    if file_format == "wav":
        return wav_reply(wav_file(records), id)
    return form.reply(record_arrays(records, measurement.setup))


@router.get(
    "/{id}/estimates",
    response_class=Response,
    responses=array_tables.ESTIMATES,
    summary="Get FRFs and coherence while averages were taken",
)
def get_estimates(id: IdPath, store: StoreDep, form: ArraysFormatDep) -> Response:
    """Return FRFs and coherence after the first averages of a measurement, which it kept, up to all of them.

    With as many averages as forces act at once, coherence is 1 by definition, whatever the noise.
    """
    return form.reply(estimate_arrays(store.measurements.get(id)))


@router.get("/{id}/arrays.h5", response_class=Response, responses=HDF5, summary="Get arrays as an HDF5 file")
def get_measurement_hdf5(id: IdPath, store: StoreDep, kind: KindWanted = None) -> Response:
    """Return the arrays of a measurement as an HDF5 file."""
    return hdf5_reply(hdf5.write(measured_as(kind, store.measurements.get(id))), id)


@router.get("/{id}/frf.uff", response_class=Response, responses=UFF, summary="Get FRFs as a universal file")
def get_measurement_uff(id: IdPath, store: StoreDep, kind: KindWanted = None) -> Response:
    """Return the FRFs of a measurement as a universal file (dataset 58)."""
    measured = store.measurements.get(id)
    converted = measured_as(kind, measured)
    content = "; ".join(["measurement", *converted.notes[len(measured.notes) :]])
    return uff_reply(uff.write(converted, origin(store.measurements.entry(id), content)), id)


@router.get(
    "/{id}/thesis.frf",
    response_class=Response,
    responses=FRF_TEXT,
    summary="Get FRFs as FRF text",
)
def get_measurement_frf_text(
    id: IdPath, store: StoreDep, decimals: Decimals = FRF_TEXT_FILE.program_decimals, kind: KindWanted = None
) -> Response:
    """Return the FRFs of a measurement in the text format of the 1992 thesis program."""
    return frf_text_reply(frf_text.write(measured_as(kind, store.measurements.get(id)), decimals), id)


@router.get("/{id}/curves", response_model=reply_of(Curves), summary="Get curves for plots")
def get_curves(id: IdPath, store: StoreDep, points: Points = 800, kind: KindWanted = None) -> Curves:
    """Return the FRFs of a measurement at fewer lines, with peaks and notches kept."""
    return curves_of(measured_as(kind, store.measurements.get(id)), points)


@router.get("/{id}/indicators", response_model=IndicatorsReply, summary="Get mode indicator functions")
def get_indicators(id: IdPath, store: StoreDep, points: Points = 800) -> Indicators:
    """Return mode indicator functions of a measurement: real part (MIF) and singular values (CMIF)."""
    return indicators_of(store.measurements.get(id), points)


@router.get("/{id}/reciprocity", response_model=ReciprocityReply, summary="Check reciprocity")
def get_reciprocity(id: IdPath, store: StoreDep) -> ReciprocityCheck:
    """Return the differences of FRFs whose force and response are exchanged."""
    return reciprocity_of(store.measurements.get(id))


@router.get("/{id}/log", response_model=LogReply, summary="Get the log book")
def get_log(id: IdPath, store: StoreDep) -> Any:
    """Return the log book of a measurement: the rig as declared, seed, versions of the libraries."""
    return log_reply(store.measurements.get(id), store.measurements.entry(id))


@router.get("/{id}/truth", response_model=TruthReply, summary="Get the truth", dependencies=[TEACHERS])
def get_truth(id: IdPath, store: StoreDep, owner: OwnerDep) -> Truth:
    """Return the structure and the effects of a simulated measurement to its owner, unless a student."""
    return store.truths.get(id, owner=owner)


add_routes(router, "measurements", "measurement")

"""What is read from a project file: made, and checked as if it had been asked for."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any

from pydantic import TypeAdapter

from modallab.api.correlations.replies import correlation_arrays, correlation_reply
from modallab.api.diagnoses.replies import diagnosis_reply
from modallab.api.measurements.estimates import estimate_arrays
from modallab.api.measurements.replies import log_reply, measurement_reply
from modallab.api.modal_models.replies import modal_model_reply
from modallab.api.projects.archive import ProjectFile, faults_of_file, refusal
from modallab.api.projects.schemas import ThingIn
from modallab.api.rigs.replies import rig_reply, rig_request
from modallab.api.rigs.schemas import RigIn
from modallab.api.structures.changes import ChangesIn
from modallab.api.structures.replies import geometry_reply, structure_reply
from modallab.api.structures.schemas import StructureIn
from modallab.api.studies.replies import study_arrays, study_reply
from modallab.api.updates.replies import update_reply
from modallab.core.errors import ModalLabError
from modallab.core.modal_model import ModalModel
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.result import Diagnosis
from modallab.fe.structure import Structure
from modallab.interchange import uff_modes
from modallab.rig.effect import build
from modallab.rig.exact import as_modelled
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.base import Entry
from modallab.store.codec import CODECS

_REQUEST: TypeAdapter[Any] = TypeAdapter(StructureIn | ChangesIn)


def _check_structure(structure: Structure, entry: Entry) -> None:
    for spec in structure.effects:
        build(spec)
    as_modelled(structure)
    for reply in (structure_reply(structure, entry), geometry_reply(structure, entry)):
        reply.model_dump_json()


def _check_rig(setup: RigSetup, entry: Entry) -> None:
    RigIn.model_validate(rig_request(setup)).to_domain()
    rig_reply(setup, entry).model_dump_json()


def _check_measurement(measurement: Measurement, entry: Entry) -> None:
    for reply in (measurement_reply, log_reply):
        reply(measurement, entry).model_dump_json()
    if measurement.estimates is not None:
        estimate_arrays(measurement)


def _check_modal_model(model: ModalModel, entry: Entry) -> None:
    modal_model_reply(model, entry, details=("flags", "notes")).model_dump_json()
    with suppress(ModalLabError):  # not every model has a form there, and is told so
        uff_modes.write(model)


def _check_diagnosis(diagnosis: Diagnosis, entry: Entry) -> None:
    diagnosis_reply(diagnosis, entry).model_dump_json()
    report(diagnosis, {**entry.inputs, "id": entry.id, "created": entry.created, "version": entry.version})


def _answers(*replies: Callable[[Any, Entry], Any]) -> Callable[[Any, Entry], None]:
    """Return the check that these replies can be written."""

    def check(thing: Any, entry: Entry) -> None:
        for reply in replies:
            reply(thing, entry).model_dump_json()

    return check


def _check_correlation(correlation: Any, entry: Entry) -> None:
    correlation_reply(correlation, entry).model_dump_json()
    correlation_arrays(correlation)


def _check_study(study: Any, entry: Entry) -> None:
    study_reply(study, entry).model_dump_json()
    study_arrays(study)


_CHECKS: Mapping[str, Callable[[Any, Entry], None]] = {
    "structure": _check_structure,
    "rig": _check_rig,
    "measurement": _check_measurement,
    "modal_model": _check_modal_model,
    "correlation": _check_correlation,
    "update": _answers(update_reply),
    "study": _check_study,
    "diagnosis": _check_diagnosis,
}


def thing_of(project: ProjectFile, read: ThingIn) -> tuple[Any, Mapping[str, Any] | None]:
    """Return a thing of a project file, and the body of the request that described it.

    Raises
    ------
    InvalidInputError
        If it is not what this version could have made.
    """
    with faults_of_file(read.id):
        body, request, arrays = project.parts(read)
        return CODECS[read.kind].put_together(body, arrays), request


def check(project: ProjectFile, read: ThingIn) -> None:
    """Raise `InvalidInputError` unless a thing of a project file can be stored and shown."""
    thing, request = thing_of(project, read)
    entry = Entry(
        id=read.id,
        kind=read.kind,
        owner="",
        created=datetime.now(UTC).isoformat(),
        version=read.version,
        inputs=read.inputs,
        seed=read.seed,
    )
    with faults_of_file(read.id):
        codec = CODECS[read.kind]
        _CHECKS[read.kind](codec.put_together(*codec.take_apart(thing)), entry)
        if request is None:
            return
        if read.kind != "structure":
            raise refusal(f"no request describes a {read.kind}", value=read.id)
        _REQUEST.validate_python(request)

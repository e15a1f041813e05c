"""Diagnosis of files on disk without a service, for `modallab diagnose`."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

import modallab
from modallab.api.diagnoses.replies import diagnosis_reply
from modallab.api.diagnoses.schemas import DiagnosisOptionsBody, diagnosis_options
from modallab.api.faults import adapter_names, faults
from modallab.api.rigs.schemas import RigIn
from modallab.api.settings import ServiceSettings
from modallab.api.structures.mesh import mesh_of
from modallab.api.structures.schemas import StructureIn
from modallab.api.wire import effect_out
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, ModalLabError, sentence
from modallab.core.physics_warning import PhysicsWarning
from modallab.core.place import EffectSpec
from modallab.core.progress import Progress
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.result import Diagnosis
from modallab.fe.structure import Structure
from modallab.interchange.declared import DeclaredTest
from modallab.interchange.reading import read_measurement
from modallab.jobs.model_files import ModelRequest, read_model_confined
from modallab.rig.effect import EFFECTS
from modallab.rig.plausibility import measurement_warnings, structure_warnings
from modallab.store.base import Entry

T = TypeVar("T")

# Names of things that end with the command.
_PASSING = ("id", "created", "made_from", "structure_id", "rig_id")


@dataclass(frozen=True)
class Files:
    """Input files: a model, the body of `POST /v1/rigs`, and measured FRFs."""

    model: Path
    """Body of `POST /v1/structures`, where it ends in .json; else what an import takes."""
    rig: Path
    measured: Path
    mesh: Path | None = None
    """What the groups of a mesh are made of, as an import takes it."""


@dataclass(frozen=True, eq=False)
class DiagnosisOutcome:
    """A diagnosis and its entry: version, date and seed."""

    diagnosis: Diagnosis
    entry: Entry

    def json(self) -> str:
        """Return the service's reply as JSON, with the effects to add to the files in place of stored ids."""
        fields = diagnosis_reply(self.diagnosis, self.entry).model_dump(mode="json")
        reply = {name: value for name, value in fields.items() if name not in _PASSING}
        added: dict[str, list[Any]] = {"model": [], "rig": []}
        for effect in (step.effect for step in self.diagnosis.steps):
            numbers = {name: parameter.value for name, parameter in effect.parameters.items()}
            file = "model" if EFFECTS[effect.kind].structural else "rig"
            added[file].append(effect_out(EffectSpec(effect.kind, effect.at, numbers)))
        return json.dumps(reply | {"added_effects": added}, indent=2)


def diagnose_files(
    files: Files,
    request: Mapping[str, Any],
    *,
    averages: float | None,
    progress: Progress,
    warn: Callable[[PhysicsWarning], None] | None = None,
) -> DiagnosisOutcome:
    """Return the diagnosis of files, made by the function that the service calls, without a store.

    Parameters
    ----------
    request
        The body of `POST /v1/diagnoses` without its ids.
    averages
        Effective averages; by default the measured file's, or else the rig's.
    warn
        Called with what is surely a slip in the files, before the work.

    Raises
    ------
    InvalidInputError
        If a file or a field is at fault; the message says which.
    """
    structure = _of_file(files.model, lambda: model_of(files))
    setup = _of_file(files.rig, lambda: _body(files.rig, RigIn).to_domain())
    with files.measured.open("rb") as file:
        largest = ServiceSettings.model_fields["upload_limit"].default
        measurement = _of_file(
            files.measured,
            lambda: read_measurement(file, setup, largest=largest, declared=DeclaredTest(averages)),
        )
    if warn is not None:
        for warning in (*structure_warnings(structure), *measurement_warnings(measurement)):
            warn(warning)
    body = _checked(TypeAdapter(DiagnosisOptionsBody), dict(request))
    options = diagnosis_options(body)
    check_comparable(structure, measurement)
    for text in options.hold_out.dofs:
        structure.index(Dof.parse(text, field="hold_out.dofs"))
    diagnosis = diagnose_with_options(structure, measurement, options, progress=progress)
    return DiagnosisOutcome(diagnosis, _entry(options.seed))


def model_of(files: Files) -> Structure:
    """Return the model of a file: JSON, Nastran bulk data, a mesh or matrices.

    Raises
    ------
    InvalidInputError
        If the file holds no model, or a mesh whose groups are not described.
    """
    if files.model.suffix.lower() == ".json":
        structure: Structure = _body(files.model, StructureIn).to_domain()
        return structure
    mesh = None if files.mesh is None else mesh_of(files.mesh.read_text(encoding="utf-8"))
    with files.model.open("rb") as file:
        largest = ServiceSettings.model_fields["upload_limit"].default
        return read_model_confined(file, ModelRequest(description=mesh), largest=largest)


def _entry(seed: int) -> Entry:
    """Return the entry of a diagnosis that is not stored."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    passing = dict.fromkeys(("extended_structure_id", "extended_rig_id"), "")
    return Entry("", "diagnoses", "", now, modallab.__version__, passing, seed)


def _body(path: Path, wire: Any) -> Any:
    try:
        body = json.loads(path.read_bytes())
    except ValueError as error:
        raise InvalidInputError(f"not JSON: {error}") from None
    return _checked(TypeAdapter(wire), body)


def _checked(wire: TypeAdapter[T], body: Any) -> T:
    try:
        return wire.validate_python(body)
    except ValidationError as error:
        fault, *_ = faults(error.errors(), body, (), adapter_names(wire))
        words = f"{fault.field}: {fault.message}" if fault.field else fault.message
        raise InvalidInputError(words) from None


def _of_file(path: Path, read: Callable[[], T]) -> T:
    """Return the result of a reading function; its errors name the file."""
    try:
        return read()
    except ModalLabError as error:
        raise InvalidInputError(f"{path.name}: {sentence(error)}") from None

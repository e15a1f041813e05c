"""Long work by name: compute and store.

A task takes the ids of stored things and its options, each as a frozen dataclass. A job carries both as
JSON values, so that any engine can bring them to a worker, which brings the store. A task may stop inside
`progress`, which raises `CancelledError`; nothing is stored then. It may run twice: the id of what it
makes is given, and stored once.

A task of `SHARES_BY_TASK` is divided into independent shares: any workers run these first, and the task gets
their results as `shares`. Without `shares` the task runs them itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

from modallab.core.progress import Progress
from modallab.diagnosis.options import DiagnosisOptions
from modallab.extraction.method_options import OPTIONS as EXTRACTION_OPTIONS
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import DiagnosisInputs, diagnose_and_store
from modallab.jobs.extracting import ExtractionInputs, ExtractionRequest, extract_and_store
from modallab.jobs.measuring import MeasurementInputs, MeasurementOptions, measure_and_store
from modallab.jobs.postponed import Postponed
from modallab.jobs.sealing import (
    SealedInputs,
    measure_sealed_and_store,
    publish_sealed,
    withdraw_sealed,
)
from modallab.jobs.studying import StudyInputs, count_runs, run_of_study, study_and_store
from modallab.jobs.updating import UpdateInputs, UpdateRequest, update_and_store
from modallab.store.base import Store
from modallab.store.plain import from_plain, to_plain
from modallab.updating.method_options import METHODS as UPDATING_METHODS
from modallab.updating.studies.plan import StudyPlan

Json = Any
InputsT = TypeVar("InputsT")
OptionsT = TypeVar("OptionsT")

_TYPE = "$type"
# Options are read by the names of their classes, which exist once the methods are imported.
METHODS_WITH_OPTIONS = (*EXTRACTION_OPTIONS, *UPDATING_METHODS)


@dataclass(frozen=True)
class Task(Generic[InputsT, OptionsT]):
    """Long work with a name; called with the arguments of a job, it does it."""

    name: str
    run: Callable[[Store, Progress, Destination, InputsT, OptionsT], Postponed | None]
    """Function of a store, a progress callback, a destination, inputs and options."""
    inputs: type[InputsT]
    """Dataclass of the ids of stored things."""
    options: type[OptionsT]
    """Dataclass of the options."""

    def arguments(self, inputs: InputsT, options: OptionsT) -> dict[str, Json]:
        """Return inputs and options as JSON values by their fields' names."""
        values = {**to_plain(inputs)[0], **to_plain(options)[0]}
        del values[_TYPE]
        return values

    def decoded(self, arguments: Mapping[str, Json]) -> tuple[InputsT, OptionsT]:
        """Return inputs and options of a job's arguments; `StoredDataError` if they do not fit."""
        ids = {f.name for f in fields(self.inputs)}  # type: ignore[arg-type]
        inputs = {name: value for name, value in arguments.items() if name in ids}
        options = {name: value for name, value in arguments.items() if name not in ids}
        return _from_fields(self.inputs, inputs), _from_fields(self.options, options)

    def __call__(
        self, store: Store, progress: Progress, into: Destination, *, shares: Json = None, **arguments: Json
    ) -> Postponed | None:
        """Run the task with a job's arguments, and store its result; return when the job ends, if later."""
        inputs, options = self.decoded(arguments)
        run: Callable[..., Postponed | None] = self.run
        return run(store, progress, into, inputs, options, **({} if shares is None else {"shares": shares}))


def _from_fields(cls: type[OptionsT], values: Mapping[str, Json]) -> OptionsT:
    return from_plain(cls, {_TYPE: cls.__name__, **values}, {})


@dataclass(frozen=True)
class Shares(Generic[InputsT, OptionsT]):
    """The parts of a task."""

    task: Task[InputsT, OptionsT]
    count_function: Callable[[InputsT, OptionsT], int]
    """Number of parts."""
    share_function: Callable[[Store, Progress, int, InputsT, OptionsT], Json]
    """One part, by its index."""

    def count(self, **arguments: Json) -> int:
        """Return the number of parts of a job with these arguments."""
        return self.count_function(*self.task.decoded(arguments))

    def run_share(self, store: Store, progress: Progress, index: int, **arguments: Json) -> Json:
        """Return one part of a job with these arguments."""
        return self.share_function(store, progress, index, *self.task.decoded(arguments))


MEASUREMENT = Task("measure_and_store", measure_and_store, MeasurementInputs, MeasurementOptions)
SEALED_MEASUREMENT = Task(
    "measure_sealed_and_store", measure_sealed_and_store, SealedInputs, MeasurementOptions
)
EXTRACTION = Task("extract_and_store", extract_and_store, ExtractionInputs, ExtractionRequest)
UPDATE = Task("update_and_store", update_and_store, UpdateInputs, UpdateRequest)
DIAGNOSIS = Task("diagnose_and_store", diagnose_and_store, DiagnosisInputs, DiagnosisOptions)
STUDY = Task("study_and_store", study_and_store, StudyInputs, StudyPlan)

TASKS: Mapping[str, Callable[..., Postponed | None]] = {
    task.name: task for task in (MEASUREMENT, SEALED_MEASUREMENT, EXTRACTION, UPDATE, DIAGNOSIS, STUDY)
}
SHARES_BY_TASK: Mapping[str, Shares[Any, Any]] = {STUDY.name: Shares(STUDY, count_runs, run_of_study)}


@dataclass(frozen=True)
class Ending(Generic[InputsT]):
    """The end of a task that is told later than its work is done."""

    task: Task[InputsT, Any]
    publish_function: Callable[[Store, Destination, InputsT, str], None]
    """Gives the result to its owner, as made at a time, ISO 8601."""
    withdraw: Callable[[Store, Destination], None]
    """Removes the result."""

    def publish(self, store: Store, into: Destination, at: str, **arguments: Json) -> None:
        """Give the result of a job with these arguments to its owner."""
        self.publish_function(store, into, self.task.decoded(arguments)[0], at)


ENDINGS_BY_TASK: Mapping[str, Ending[Any]] = {
    SEALED_MEASUREMENT.name: Ending(SEALED_MEASUREMENT, publish_sealed, withdraw_sealed)
}

"""Long work by name: compute and store.

Each task is a module-level function of JSON values, so that any engine can carry it to a worker,
which brings the store. It may stop inside `progress`, which raises `CancelledError`; nothing is
stored then. It may run twice: the id of what it makes is given, and stored once.

A task of `SHARES_BY_TASK` is divided into independent shares: any workers run these first, and the task gets
their results as `shares`. Without `shares` the task runs them itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from modallab.jobs.diagnosing import diagnose_and_store
from modallab.jobs.extracting import extract_and_store
from modallab.jobs.measuring import measure_and_store
from modallab.jobs.studying import count_runs, run_of_study, study_and_store
from modallab.jobs.updating import update_and_store

Json = Any
Task = Callable[..., None]


@dataclass(frozen=True)
class Shares:
    """The parts of a task; what is called besides with the task's own arguments."""

    count: Callable[..., int]
    run_share: Callable[..., Json]  # of the store, a progress callback and the share's index


TASKS: Mapping[str, Task] = {
    "measure_and_store": measure_and_store,
    "extract_and_store": extract_and_store,
    "update_and_store": update_and_store,
    "diagnose_and_store": diagnose_and_store,
    "study_and_store": study_and_store,
    # Names of before one task ran them all, under which jobs may still wait.
    "update_directly_and_store": update_and_store,
    "locate_and_store": update_and_store,
}
SHARES_BY_TASK: Mapping[str, Shares] = {"study_and_store": Shares(count_runs, run_of_study)}

"""Long work by name: compute and store.

Each task is a module-level function of JSON values, so that any engine can carry it to a worker,
which brings the store. It may stop inside `progress`, which raises `CancelledError`; nothing is
stored then. It may run twice: the id of what it makes is given, and stored once.
"""

from collections.abc import Callable, Mapping

from modallab.jobs.diagnosing import diagnose_and_store
from modallab.jobs.extracting import extract_and_store
from modallab.jobs.measuring import measure_and_store
from modallab.jobs.updating import update_and_store

Task = Callable[..., None]
TASKS: Mapping[str, Task] = {
    "measure_and_store": measure_and_store,
    "extract_and_store": extract_and_store,
    "update_and_store": update_and_store,
    "diagnose_and_store": diagnose_and_store,
    # Names of before one task ran them all, under which jobs may still wait.
    "update_directly_and_store": update_and_store,
    "locate_and_store": update_and_store,
}

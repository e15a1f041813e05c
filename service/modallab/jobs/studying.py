"""Studies: runs of a method on noisy modes of a known structure, distributed over workers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.progress import Progress, part
from modallab.fe.structure import Structure
from modallab.jobs.destination import Destination
from modallab.rig.exact import as_modelled, with_effects
from modallab.store.base import Store
from modallab.store.plain import from_plain, to_plain
from modallab.updating.studies.plan import StudyPlan
from modallab.updating.studies.run import StudyUpdate, failed_run, run_once
from modallab.updating.studies.study import Study
from modallab.updating.studies.truth import Values, true_coefficients

Json = Any

_FAULT = "the service failed at this run; its log says why"


@dataclass(frozen=True)
class StudyInputs:
    """Stored things that a study is made from: the model that is corrected, and its changed copy."""

    structure_id: str
    truth_id: str


def count_runs(_inputs: StudyInputs, plan: StudyPlan) -> int:
    """Return the number of runs of a study."""
    return plan.n_runs


def run_of_study(store: Store, progress: Progress, index: int, inputs: StudyInputs, plan: StudyPlan) -> Json:
    """Return one run of a study and its coefficients as plain values; `CancelledError` from `progress`."""
    model, truth = _structures(store, inputs)
    true = true_coefficients(model, truth, plan.parts)
    run, coefficients = run_once(plan, index, model, as_modelled(truth), true, progress)
    return [to_plain(run)[0], None if coefficients is None else coefficients.tolist()]


def study_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    inputs: StudyInputs,
    plan: StudyPlan,
    shares: Sequence[Json] | None = None,
) -> None:
    """Store the results of all runs of a study; do the runs here that no worker has done.

    Parameters
    ----------
    shares
        From `run_of_study`, in order; None for one that our own fault kept from being made.
    """
    true = true_coefficients(*_structures(store, inputs), plan.parts)
    if shares is None:
        n = plan.n_runs
        shares = [run_of_study(store, part(progress, i / n, (i + 1) / n), i, inputs, plan) for i in range(n)]
    study = _study(plan, true, shares)
    store.studies.add(study, owner=into.owner, inputs=vars(inputs), id=into.id)


def _structures(store: Store, inputs: StudyInputs) -> tuple[Structure, Structure]:
    """Return the model and its changed copy."""
    model, truth = (store.structures.get(id) for id in (inputs.structure_id, inputs.truth_id))
    return with_effects(model), with_effects(truth)


def _study(plan: StudyPlan, true: Values, shares: Sequence[Json]) -> Study:
    runs: list[StudyUpdate] = []
    rows: list[FloatArray] = []
    for index, share in enumerate(shares):
        if share is None:
            runs.append(failed_run(plan, index, _FAULT))
            continue
        run, coefficients = share
        runs.append(from_plain(StudyUpdate, run, {}))
        if coefficients is not None:
            rows.append(np.array(coefficients))
    table = np.stack(rows) if rows else np.empty((0, sum(map(len, true.values()))))
    return Study(plan, true, tuple(runs), table)

"""Studies: a method tried again and again on noisy modes of a known structure, its runs shared out."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.progress import Progress, part
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


def count_runs(*, plan: Json, **_ids: str) -> int:
    """Return how many runs a study has."""
    return from_plain(StudyPlan, plan, {}).n_runs


def run_of_study(
    store: Store, progress: Progress, index: int, *, structure_id: str, truth_id: str, plan: Json
) -> Json:
    """Return one run of a study and its coefficients as plain values; `CancelledError` from `progress`."""
    study_plan = from_plain(StudyPlan, plan, {})
    model, truth = (with_effects(store.structures.get(id)) for id in (structure_id, truth_id))
    true = true_coefficients(model, truth, study_plan.parts)
    run, coefficients = run_once(study_plan, index, model, as_modelled(truth), true, progress)
    return [to_plain(run)[0], None if coefficients is None else coefficients.tolist()]


def study_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    truth_id: str,
    plan: Json,
    shares: Sequence[Json] | None = None,
) -> None:
    """Keep what all runs of a study found; make those here that nobody has made.

    Parameters
    ----------
    shares
        From `run_of_study`, in order; None for one that our own fault kept from being made.
    """
    study_plan = from_plain(StudyPlan, plan, {})
    ids = {"structure_id": structure_id, "truth_id": truth_id}
    model, truth = (with_effects(store.structures.get(id)) for id in (structure_id, truth_id))
    true = true_coefficients(model, truth, study_plan.parts)
    if shares is None:
        n = study_plan.n_runs
        shares = [
            run_of_study(store, part(progress, i / n, (i + 1) / n), i, plan=plan, **ids) for i in range(n)
        ]
    store.studies.add(_study(study_plan, true, shares), owner=into.owner, inputs=ids, id=into.id)


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

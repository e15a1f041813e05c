"""One update of a study, compared with the true coefficients."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import CancelledError, ModalLabError
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes, synthetic_modes
from modallab.fe.system import DynamicSystem
from modallab.updating.error_location.method import LocationResult
from modallab.updating.error_location.run import locate
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import LocationOptions
from modallab.updating.parameterisation import Part
from modallab.updating.studies.plan import Division, StudyPlan
from modallab.updating.studies.truth import Values, erroneous_coefficients


@dataclass(frozen=True)
class StudyUpdate:
    """Result of one update of a study; numbers are None where the update failed."""

    level: str
    """Name of the noise level."""
    division: str
    """Name of the division into macro elements."""
    seed: int
    """Seed of the noise."""
    converged: bool
    """True if the update converged."""
    stopped_because: str
    """Reason for the end, for readers."""
    suspected: Mapping[str, tuple[int, ...]]
    """Suspected members by part."""
    all_suspected: bool
    """True if every wrong coefficient was suspected."""
    n_unfounded: int
    """Suspected coefficients that are right."""
    coefficient_error: float | None = None
    """Largest absolute error of a coefficient."""
    frequency_error: float | None = None
    """Largest relative error of a natural frequency of the updated model; None for error location."""
    coverage: float | None = None
    """Share of 95 % intervals that hold the true coefficient; None without intervals."""

    @property
    def succeeded(self) -> bool:
        """True if the method gave a result."""
        return self.coefficient_error is not None


def run_once(
    plan: StudyPlan,
    index: int,
    model: Structure,
    truth: DynamicSystem,
    true: Values,
    progress: Progress = silent,
) -> tuple[StudyUpdate, FloatArray | None]:
    """Return the result of one run of a study, and its coefficients (n_coefficients,) in the order of `true`.

    A failed run states its reason and has no coefficients.

    Parameters
    ----------
    truth
        System whose modes are measured.
    true
        From `true_coefficients`.

    Raises
    ------
    CancelledError
        From `progress`.
    """
    level, division, seed = plan.run(index)
    rng = np.random.default_rng(seed)
    try:
        target = synthetic_modes(truth, plan.count, plan.dofs, noise=level.noise, rng=rng)
        result = _run_method(plan, division, model, target, progress)
    except CancelledError:
        raise
    except (ModalLabError, np.linalg.LinAlgError) as error:
        return failed_run(plan, index, str(error)), None
    frequencies = np.sort(lowest_modes(truth, plan.count)[0].frequencies)
    return _compared_with_truth(result, (level.name, division.name, seed), true, frequencies)


def failed_run(plan: StudyPlan, index: int, why: str) -> StudyUpdate:
    """Return the result of a failed run."""
    level, division, seed = plan.run(index)
    return StudyUpdate(level.name, division.name, seed, False, why, {}, all_suspected=False, n_unfounded=0)


def _run_method(
    plan: StudyPlan, division: Division, model: Structure, target: ModalModel, progress: Progress
) -> UpdateResult | LocationResult:
    parameterisation = division.parameterisation
    if isinstance(plan.options, LocationOptions):
        return locate(model, parameterisation, plan.method, target, options=plan.options, progress=progress)
    return UPDATERS[plan.method](model, parameterisation, target, options=plan.options, progress=progress)


def _compared_with_truth(
    result: UpdateResult | LocationResult,
    key: tuple[str, str, int],
    true: Values,
    frequencies: FloatArray,
) -> tuple[StudyUpdate, FloatArray]:
    coefficients = result.coefficients
    estimates = np.array(
        [coefficients.get(part, {}).get(n, Part(part).nominal) for part, table in true.items() for n in table]
    )
    true_values = np.array([value for table in true.values() for value in table.values()])
    erroneous = {(part, n) for part, table in erroneous_coefficients(true).items() for n in table}
    suspects = {(part, n) for part, members in result.suspected.items() for n in members}
    run = StudyUpdate(
        *key,
        converged=False,
        stopped_because=result.stopped_because,
        suspected=dict(result.suspected),
        all_suspected=erroneous <= suspects,
        n_unfounded=len(suspects - erroneous),
        coefficient_error=float(np.abs(estimates - true_values).max()),
    )
    if isinstance(result, LocationResult):
        return run, estimates
    is_covered = [
        low <= true[part][n] <= high
        for part, table in result.intervals.items()
        for n, (low, high) in table.items()
    ]
    updated = replace(
        run,
        converged=result.converged,
        stopped_because=result.stopped_because,
        frequency_error=float(np.abs(np.sort(result.frequencies.after) / frequencies - 1).max()),
        coverage=float(np.mean(is_covered)) if is_covered else None,
    )
    return updated, estimates

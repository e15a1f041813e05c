"""Result of a study."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.studies.plan import StudyPlan
from modallab.updating.studies.run import StudyUpdate
from modallab.updating.studies.settings import STUDY
from modallab.updating.studies.truth import Values, erroneous_coefficients


@dataclass(frozen=True)
class StudyCell:
    """Statistics of the runs of one level and division; quantiles are of successful runs."""

    level: str
    """Name of the noise level."""
    division: str
    """Name of the division into macro elements."""
    n_runs: int
    """Number of runs."""
    n_failed: int
    """Runs without a result."""
    n_converged: int
    """Runs that converged."""
    suspected: float
    """Share of all runs in which every wrong coefficient was suspected."""
    unfounded: float
    """Suspected coefficients that are right, mean of successful runs."""
    coefficient_error: tuple[float, float] | None
    """Median and 90 % quantile of the largest error of a coefficient in a run."""
    frequency_error: tuple[float, float] | None
    """Median and 90 % quantile of the largest relative error of a frequency in a run."""
    coverage: float | None
    """Mean share of 95 % intervals that hold the true coefficient."""


@dataclass(frozen=True, eq=False)
class Study:
    """Study of an updating method on noisy modes of a known structure."""

    plan: StudyPlan
    """Plan of the study."""
    true: Values
    """True coefficients by part and member."""
    runs: tuple[StudyUpdate, ...]
    """Results of all runs."""
    coefficients: FloatArray
    """Estimated coefficients of successful runs (n_succeeded, n_coefficients), in the order of `true`."""

    def __post_init__(self) -> None:
        shape = (sum(run.succeeded for run in self.runs), sum(map(len, self.true.values())))
        table = frozen(self.coefficients, float, shape, name="coefficients")
        object.__setattr__(self, "coefficients", table)

    @property
    def wrong(self) -> dict[str, dict[int, float]]:
        """True coefficients that differ from nominal."""
        return erroneous_coefficients(self.true)

    @property
    def cells(self) -> tuple[StudyCell, ...]:
        """Table of the study: one row a level and division."""
        n = len(self.plan.seeds)
        return tuple(_cell(self.runs[i : i + n]) for i in range(0, len(self.runs), n))


def _cell(runs: Sequence[StudyUpdate]) -> StudyCell:
    completed_runs = [run for run in runs if run.succeeded]
    coverages = [run.coverage for run in completed_runs if run.coverage is not None]
    return StudyCell(
        level=runs[0].level,
        division=runs[0].division,
        n_runs=len(runs),
        n_failed=len(runs) - len(completed_runs),
        n_converged=sum(run.converged for run in completed_runs),
        suspected=float(np.mean([run.all_suspected for run in runs])),
        unfounded=float(np.mean([run.n_unfounded for run in completed_runs])) if completed_runs else 0.0,
        coefficient_error=_quantiles([run.coefficient_error for run in completed_runs]),
        frequency_error=_quantiles([run.frequency_error for run in completed_runs]),
        coverage=float(np.mean(coverages)) if coverages else None,
    )


def _quantiles(values: Sequence[float | None]) -> tuple[float, float] | None:
    numbers = [value for value in values if value is not None]
    if not numbers:
        return None
    median, most = np.quantile(numbers, [0.5, STUDY.error_quantile])
    return float(median), float(most)

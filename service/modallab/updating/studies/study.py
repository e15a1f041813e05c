"""What comes back from a study."""

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
    """The runs of one level and division; quantiles are of those that were made."""

    level: str
    division: str
    n_runs: int
    n_failed: int  # could not be made
    n_converged: int
    suspected: float  # share of all runs in which every wrong coefficient was suspected
    unfounded: float  # suspects that are right, mean over the runs that were made
    coefficient_error: tuple[float, float] | None  # median and 90 % of the largest error of a run
    frequency_error: tuple[float, float] | None
    coverage: float | None  # mean


@dataclass(frozen=True, eq=False)
class Study:
    """A method tried on noisy modes of a known structure."""

    plan: StudyPlan
    true: Values  # coefficients of every member
    runs: tuple[StudyUpdate, ...]
    coefficients: FloatArray  # (n_made, n_coefficients) of the runs that were made, in the order of `true`

    def __post_init__(self) -> None:
        shape = (sum(run.succeeded for run in self.runs), sum(map(len, self.true.values())))
        table = frozen(self.coefficients, float, shape, name="coefficients")
        object.__setattr__(self, "coefficients", table)

    @property
    def wrong(self) -> dict[str, dict[int, float]]:
        """The coefficients that are to be found."""
        return erroneous_coefficients(self.true)

    @property
    def cells(self) -> tuple[StudyCell, ...]:
        """The table: one row a level and division."""
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

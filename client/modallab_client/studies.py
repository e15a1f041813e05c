"""How surely an updating method finds known errors, by the noise of the modes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from modallab_client import _plots, _tables
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class StudyCell:
    """The runs of one level and division; errors are the largest of a run: their median and 90 %."""

    level: str
    division: str
    n_runs: int
    n_failed: int  # that could not be made
    n_converged: int
    suspected: float  # share of runs in which every wrong coefficient was suspected
    unfounded: float  # suspects that are right, a run
    coefficient_error: tuple[float, float] | None  # None where no run could be made
    frequency_error: tuple[float, float] | None  # relative; None of a method that only locates
    coverage: float | None  # share of 95 % intervals that hold the truth; None of a method without


@dataclass(frozen=True)
class StudyRun:
    """One update of a study; its numbers are None if it could not be made."""

    level: str
    division: str
    seed: int
    converged: bool
    stopped_because: str
    suspected: Mapping[str, tuple[int, ...]]  # part -> members
    all_suspected: bool
    n_unfounded: int
    coefficient_error: float | None
    frequency_error: float | None
    coverage: float | None


@dataclass(frozen=True, eq=False)
class Study:
    """A method tried on noisy modes of a known structure."""

    id: str
    method: str
    levels: tuple[str, ...]
    divisions: tuple[str, ...]
    seeds: tuple[int, ...]
    wrong: Mapping[str, Mapping[int, float]]  # part -> member -> coefficient that was to be found
    cells: tuple[StudyCell, ...]  # by level, then division
    runs: tuple[StudyRun, ...]  # by level, division, seed

    def table(self) -> str:
        """Return a row for every level and division as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        rows = [
            (
                cell.level,
                cell.division,
                str(cell.n_runs),
                str(cell.n_failed),
                f"{cell.suspected:.0%}",
                f"{cell.unfounded:.2g}",
                *_pair(cell.coefficient_error),
                *_pair(cell.frequency_error),
                "" if cell.coverage is None else f"{cell.coverage:.1%}",
            )
            for cell in self.cells
        ]
        head = ("level", "division", "runs", "failed", "all suspected", "unfounded")
        errors = ("coefficient", "90 %", "frequency", "90 %")
        return (*head, *errors, "in 95 %"), rows

    def plot(self) -> "tuple[Axes, ...]":
        """Draw errors, suspects and coverage by level, a line for every division; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.study(self)

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Study {self.id}: {self.method}, largest error of a run")


def _pair(values: tuple[float, float] | None) -> tuple[str, str]:
    return ("", "") if values is None else (f"{values[0]:.2g}", f"{values[1]:.2g}")


@dataclass(frozen=True, eq=False)
class StudyCoefficients:
    """The coefficients that every run of a study found."""

    parts: tuple[str, ...]  # (n_coefficients,)
    members: tuple[int, ...]  # (n_coefficients,)
    true: FloatArray  # (n_coefficients,)
    found: FloatArray  # (n_runs, n_coefficients) in the order of `Study.runs`, NaN where none was made

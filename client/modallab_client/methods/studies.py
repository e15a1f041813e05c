"""Studies: their coefficients, a table and pictures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import Study, StudyCell, StudyPlan


class StudyMethods:
    """A study has a table and pictures."""

    if TYPE_CHECKING:
        id: str
        plan: StudyPlan
        cells: tuple[StudyCell, ...]

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
        return _plots.study(cast("Study", self))

    def _repr_html_(self) -> str:
        return _tables.html(
            *self._rows(), caption=f"Study {self.id}: {self.plan.method}, largest error of a run"
        )


def _pair(values: tuple[float, float] | None) -> tuple[str, str]:
    return ("", "") if values is None else (f"{values[0]:.2g}", f"{values[1]:.2g}")


@dataclass(frozen=True, eq=False)
class StudyCoefficients:
    """Coefficients that every run of a study found."""

    parts: tuple[str, ...]
    """(n_coefficients,) corrected part of each coefficient."""
    members: tuple[int, ...]
    """(n_coefficients,) member of each coefficient."""
    true: FloatArray
    """(n_coefficients,) true coefficients."""
    found: FloatArray
    """(n_runs, n_coefficients) in the order of `Study.runs`, NaN for a failed run."""


def study_coefficients(arrays: Mapping[str, NDArray[Any]]) -> StudyCoefficients:
    """Return the coefficients of all runs from the arrays of an npz file."""
    return StudyCoefficients(
        parts=tuple(map(str, arrays["parts"])),
        members=tuple(map(int, arrays["members"])),
        true=arrays["true"],
        found=arrays["coefficients"],
    )

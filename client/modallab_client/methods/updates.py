"""Updates: tables, pictures and arrays of the results of each family of methods."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client import _plots, _tables
from modallab_client._numbers import concise, rounded
from modallab_client._read import read_as
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import DirectUpdate, DofError, MacroElement

_NAMED = 5  # coefficients that a summary names
_LEAST_CHANGE = 1e-3  # of a coefficient that counts as corrected: models are not known any better

Table = Mapping[str, Mapping[int, float]]
"""Numbers by part and member."""


class Update:
    """Result of an updating method, a type for each family.

    `IterativeUpdate`, `ResponseBasedUpdate`, `DirectUpdate` or `ErrorLocation`, told apart by `kind`.
    Coefficients multiply an element's matrix, 1 = no change; those of damping are loss factors added to an
    element's own, 0 = no change.
    """

    if TYPE_CHECKING:

        @property
        def id(self) -> str: ...
        @property
        def kind(self) -> str: ...
        @property
        def converged(self) -> bool: ...
        @property
        def stopped_because(self) -> str: ...
        @property
        def coefficients(self) -> Table: ...
        @property
        def frequencies(self) -> Mapping[str, FloatArray]: ...
        @property
        def structure_id(self) -> str | None: ...

    @property
    def direct(self) -> "DirectUpdate | None":
        """The result if it is that of a direct method; None of other methods."""
        from modallab_client._generated.models import DirectUpdate

        return self if isinstance(self, DirectUpdate) else None

    def table(self) -> str:
        """Return coefficients with standard errors and 95 % intervals, or the errors located, as text."""
        return _tables.text(*self._rows())

    def summary(self) -> str:
        """Return in plain sentences how the method ended, and what it corrected."""
        return f"{self.stopped_because[:1].upper()}{self.stopped_because[1:]}."

    def _rows(self) -> _tables.Table:
        raise NotImplementedError

    def plot(self) -> "Axes":
        """Draw the coefficients by member, or errors by DoF; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.coefficients(self.coefficients, {})

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Update {self.id}: {self.stopped_because}")


class _CorrectedCoefficients(Update):
    if TYPE_CHECKING:
        standard_errors: Mapping[str, Mapping[int, float | None]]
        intervals: Mapping[str, Mapping[int, tuple[float, float]]]

    def _rows(self) -> _tables.Table:
        rows = [
            (
                part,
                str(member),
                rounded(value, error),
                _error(error),
                _ends(self.intervals.get(part, {}).get(member)),
            )
            for part, member, value, error in self._known()
        ]
        return ("part", "member", "coefficient", "standard error", "95 % by the data"), rows

    def _known(self) -> Iterator[tuple[str, int, float, float | None]]:
        """Yield part, member, coefficient and standard error."""
        for part, members in self.coefficients.items():
            for member, value in members.items():
                yield part, member, value, self.standard_errors.get(part, {}).get(member)

    def summary(self) -> str:
        """Return how the method ended, the coefficients that it corrected, and the frequencies."""
        changed = sorted(
            (
                (abs(value - _unchanged(part)), part, member, value, error)
                for part, member, value, error in self._known()
                if abs(value - _unchanged(part)) > max(_LEAST_CHANGE, 2 * (error or 0.0))
            ),
            reverse=True,
        )
        names = [f"{part} of {member} {concise(value, error)}" for _, part, member, value, error in changed]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        corrected = (
            f"Corrected: {', '.join(names[:_NAMED])}{more}." if names else "No coefficient was corrected."
        )
        return " ".join([super().summary(), corrected, *self._frequencies()])

    def _frequencies(self) -> list[str]:
        """Return how far the natural frequencies differ, where both sides are known mode by mode."""
        stages = [self.frequencies.get(name) for name in ("measured", "before", "after")]
        known = [np.asarray(stage, dtype=float) for stage in stages if stage is not None]
        if len(known) < len(stages) or len({len(stage) for stage in known}) > 1 or not len(known[0]):
            return []
        measured, before, after = known
        first, last = (100 * np.nanmax(np.abs(stage / measured - 1)) for stage in (before, after))
        return [f"Natural frequencies differ by at most {first:.2g} % before and {last:.2g} % after."]

    def plot(self) -> "Axes":
        """Draw the coefficients by member with their standard errors; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.coefficients(self.coefficients, self.standard_errors)


class IterativeUpdateMethods(_CorrectedCoefficients):
    """An update on modes has a table and a picture."""


class ResponseBasedUpdateMethods(_CorrectedCoefficients):
    """An update on FRFs has a table and a picture."""


class _WithoutStructure(Update):
    @property
    def structure_id(self) -> None:
        """None: the method makes no structure."""
        return


class DirectUpdateMethods(_WithoutStructure):
    """A direct update has a table and a picture of the errors by DoF."""

    if TYPE_CHECKING:
        dof_errors: Mapping[str, tuple[DofError, ...]]

    def _rows(self) -> _tables.Table:
        rows = [
            (matrix, item.dof, f"{item.error:.3g}")
            for matrix, errors in self.dof_errors.items()
            for item in errors
        ]
        return ("matrix", "DoF", "relative error"), rows

    def plot(self) -> "Axes":
        """Draw the errors by DoF, the largest first; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        errors = {matrix: [item.error for item in items] for matrix, items in self.dof_errors.items()}
        return _plots.dof_errors(errors)


class ErrorLocationMethods(_WithoutStructure):
    """An error location has first-order coefficients, a table and a picture."""

    if TYPE_CHECKING:
        changes: Table
        weights: Table

    @property
    def converged(self) -> bool:
        """False: nothing is corrected."""
        return False

    @property
    def coefficients(self) -> Table:
        """First-order coefficients by part and member."""
        return {
            part: {member: (0.0 if part == "damping" else 1.0) + change for member, change in table.items()}
            for part, table in self.changes.items()
        }

    def _rows(self) -> _tables.Table:
        rows = [
            (part, str(member), f"{change:.4g}", f"{self.weights[part][member]:.3g}")
            for part, members in self.changes.items()
            for member, change in members.items()
            if change
        ]
        return ("part", "member", "change", "weight"), rows


class DirectionMethods:
    """A direction prints as its description."""

    if TYPE_CHECKING:
        words: str
        standard_error: float | None
        macros: tuple[MacroElement, ...]

    def __str__(self) -> str:
        error = self.standard_error
        return self.words if error is None else f"{self.words} (standard error {error:.2g})"


class QuantityMethods:
    """A quantity prints with its unit and interval."""

    if TYPE_CHECKING:
        part: Any
        members: tuple[int, ...]
        unit: str
        before: float
        after: float
        interval: tuple[float, float] | None

    def __str__(self) -> str:
        place = ", ".join(map(str, self.members))
        interval = f" (95 %: {_ends(self.interval)})" if self.interval else ""
        return f"{self.part} of {place}: {self.after:.4g} {self.unit}, was {self.before:.4g}{interval}"


class ResponseFitMethods:
    """A fit of responses prints its mean squares."""

    if TYPE_CHECKING:
        before: float
        after: float
        scatter: float
        n_lines: int

    def __str__(self) -> str:
        values = f"{self.after:.3g}, was {self.before:.3g}; 1 +- {self.scatter:.2g} by random error alone"
        return f"mean square of {self.n_lines} lines: {values}"


def _error(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}"


def _ends(interval: tuple[float, float] | None) -> str:
    """Return the ends of an interval of 95 %, to one digit of the standard error."""
    if interval is None:
        return ""
    lower, upper = interval
    one_digit = 10 * (upper - lower) / 4
    return " to ".join(f"{float(rounded(end, one_digit, least=3)):.12g}" for end in interval)


def _unchanged(part: str) -> float:
    """Return the coefficient of a part that is as in the model."""
    return 0.0 if part == "damping" else 1.0


def update_of(data: Mapping[str, Any]) -> Update:
    """Return an update from its JSON, as the type of its kind."""
    from modallab_client._generated import models

    types: Mapping[str, type[Update]] = {
        "iterative": models.IterativeUpdate,
        "response_based": models.ResponseBasedUpdate,
        "direct": models.DirectUpdate,
        "error_location": models.ErrorLocation,
    }
    return read_as(types[data["kind"]], data)

"""Updated models; and correlations, from `correlation`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from modallab_client import _plots, _tables, identified
from modallab_client.direct import DirectFindings as DirectFindings
from modallab_client.direct import Suspects as Suspects
from modallab_client.identified import Identifiability as Identifiability
from modallab_client.identified import Posterior as Posterior
from modallab_client.identified import Quantity as Quantity
from modallab_client.identified import Responses as Responses
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class MacroCoefficient:
    """The coefficient that members share during an iteration."""

    part: str
    members: tuple[int, ...]
    value: float


@dataclass(frozen=True, eq=False)
class Iteration:
    """One step of an update."""

    stage: str  # location or updating
    coefficients: tuple[MacroCoefficient, ...]
    max_change: float | None
    rank: int | None
    condition_number: float | None
    frequencies: FloatArray  # (n_modes,) Hz, of the model at this step
    mac: FloatArray  # (n_modes,)


@dataclass(frozen=True, eq=False)
class Update:
    """A model brought closer to a test; coefficients multiply an element's matrix, 1 = no change.

    Those of damping are loss factors added to an element's own, 0 = no change.
    """

    id: str
    converged: bool
    stopped_because: str
    iterations: Mapping[str, int]  # of location and updating
    coefficients: Mapping[str, Mapping[int, float]]  # part -> member -> coefficient
    standard_errors: Mapping[str, Mapping[int, float]]
    suspected: Mapping[str, tuple[int, ...]]  # part -> members that location left over
    frequencies: Mapping[str, FloatArray]  # measured, before, location, after; Hz
    mac: Mapping[str, FloatArray]
    rank: int | None
    condition_number: float | None
    structure_id: str | None  # the updated model; None of direct methods, see `updates.matrices`
    history: tuple[Iteration, ...] = ()
    intervals: Mapping[str, Mapping[int, tuple[float, float]]] = field(default_factory=dict)  # 95 %, by data
    identifiability: Identifiability | None = None
    quantities: tuple[Quantity, ...] = ()  # properties in their own units
    responses: Responses | None = None  # of methods that take FRFs
    posterior: Posterior | None = None  # if draws were asked for
    direct: DirectFindings | None = None  # of methods that work on matrices
    suspects: Suspects | None = None  # of methods that locate errors by one step

    def table(self) -> str:
        """Return coefficients with standard errors and 95 % intervals, or the errors located, as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        if self.direct is not None:
            found = self.direct.dof_errors.items()
            errors = [(name, dof, f"{error:.3g}") for name, dofs in found for dof, error in dofs.items()]
            return ("matrix", "DoF", "relative error"), errors
        if self.suspects is not None:
            return ("part", "member", "change", "weight"), self.suspects.rows()
        rows = [
            (
                part,
                str(member),
                f"{value:.4g}",
                _error(self.standard_errors.get(part, {}).get(member)),
                identified.ends(self.intervals.get(part, {}).get(member)),
            )
            for part, members in self.coefficients.items()
            for member, value in members.items()
        ]
        return ("part", "member", "coefficient", "standard error", "95 % by the data"), rows

    def plot(self) -> "Axes":
        """Draw the coefficients by member, or errors by DoF; return the axes."""
        return _plots.update(self)

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Update {self.id}: {self.stopped_because}")


def _error(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}"

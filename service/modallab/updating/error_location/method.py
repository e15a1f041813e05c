"""Methods of error location: their interface and their result."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from modallab.core.arrays import BoolArray, FloatArray, frozen
from modallab.core.registry import Family, first_line
from modallab.core.reply import NanFloat, Vector
from modallab.updating.iteration import StopReason
from modallab.updating.options import LocationOptions
from modallab.updating.part import Part


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Balanced differences between measurement and model, with their sensitivity matrix."""

    sensitivity: FloatArray  # (n_rows, n_params) each row divided by its scale
    difference: FloatArray  # (n_rows,) measured minus model, likewise

    def __post_init__(self) -> None:
        n = len(self.difference)
        object.__setattr__(self, "difference", frozen(self.difference, float, (n,), name="difference"))
        object.__setattr__(
            self, "sensitivity", frozen(self.sensitivity, float, (n, None), name="sensitivity")
        )


@dataclass(frozen=True, eq=False)
class LinearLocation:
    """Suspected coefficients of one linear step."""

    change: FloatArray
    """First-order change of each coefficient (n_params,); 0 where none was solved for."""
    weight: FloatArray
    """Share of the difference that each change explains (n_params,)."""
    suspected: BoolArray
    """True for suspected coefficients (n_params,)."""
    remaining: FloatArray
    """Residual after 1, 2, ... coefficients, over the difference (k,); empty without subset selection."""
    rank: int
    condition_number: float


class Locator(Protocol):
    """Method of error location by one linear step."""

    def __call__(self, problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
        """Return the suspected coefficients.

        Parameters
        ----------
        threshold
            Change of a coefficient below which it is not suspected.
        jump
            Ratio of consecutive singular values that ends the rank.
        """
        ...


@dataclass(frozen=True)
class ErrorLocationMethod:
    """A method of error location with its options; called, it locates errors."""

    locate: Locator
    """Suspected coefficients of one linear step."""
    options: type[LocationOptions] = LocationOptions
    """Options dataclass of the method."""
    parts: tuple[Part, ...] = (Part.MASS, Part.STIFFNESS)
    """Parts of the members' matrices that are examined by default."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.locate)

    def __call__(self, problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
        """Return the located errors."""
        return self.locate(problem, threshold=threshold, jump=jump)


LOCATORS: Family[ErrorLocationMethod] = Family(
    "updating method", home="modallab.updating.error_location.methods"
)


@dataclass(frozen=True, eq=False)
class LocationResult:
    """Members suspected by error location; the model stays unchanged."""

    method: str
    """Name of the method."""
    changes: Mapping[str, Mapping[int, float]]
    """First-order change of each coefficient, by part and member."""
    weights: Mapping[str, Mapping[int, float]]
    """Share of the difference that each change explains, by part and member."""
    suspected: Mapping[str, tuple[int, ...]]
    """Suspected members by part."""
    remaining: Vector
    """Residual after 1, 2, ... coefficients, over the difference (k,); empty without subset selection."""
    measured: FloatArray
    """Hz, measured natural frequencies (n_modes,)."""
    frequencies: FloatArray
    """Hz, natural frequencies of the paired modes of the model (n_modes,)."""
    mac: FloatArray
    """Modal assurance criterion of each pair (n_modes,)."""
    rank: int
    """Rank of the balanced sensitivity matrix."""
    condition_number: NanFloat
    """Largest over smallest singular value within the rank."""

    def __post_init__(self) -> None:
        for name in ("remaining", "measured", "frequencies", "mac"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (None,), name=name))

    @property
    def stopped_because(self) -> str:
        """Reason for the end, for readers."""
        return StopReason.LOCATED if any(self.suspected.values()) else StopReason.NOT_LOCATED

    @property
    def coefficients(self) -> dict[str, dict[int, float]]:
        """First-order coefficients by part and member."""
        return {
            part: {member: Part(part).nominal + change for member, change in table.items()}
            for part, table in self.changes.items()
        }

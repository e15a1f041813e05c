"""What a method of error location is, and what it returns."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from modallab.core.arrays import BoolArray, FloatArray, frozen
from modallab.core.registry import Family, first_line
from modallab.updating.options import LocationOptions
from modallab.updating.part import Part

LOCATED = "errors are located, nothing is corrected"


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Balanced differences between measurement and model, and how coefficients would move them."""

    sensitivity: FloatArray  # (n_rows, n_params) each row over its own size
    difference: FloatArray  # (n_rows,) measured minus model, likewise

    def __post_init__(self) -> None:
        n = len(self.difference)
        object.__setattr__(self, "difference", frozen(self.difference, float, (n,), name="difference"))
        object.__setattr__(
            self, "sensitivity", frozen(self.sensitivity, float, (n, None), name="sensitivity")
        )


@dataclass(frozen=True, eq=False)
class LinearLocation:
    """Which coefficients a method suspects."""

    change: FloatArray  # (n_params,) of each coefficient, to first order; 0 where none was solved for
    weight: FloatArray  # (n_params,) how much of the difference each stands for
    suspected: BoolArray  # (n_params,)
    remaining: FloatArray  # (k,) share of the difference left by 1, 2, ... of them; empty if not searched so
    rank: int
    condition_number: float


class Locator(Protocol):
    """Says which coefficients are wrong, from one linear step."""

    def __call__(self, problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
        """Return the suspected coefficients.

        Parameters
        ----------
        threshold
            Change of a coefficient below which it is not suspected.
        jump
            Of singular values, where the rank ends.
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
    """Parts of the members' matrices that are looked at where none are named."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.locate)

    def __call__(self, problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
        return self.locate(problem, threshold=threshold, jump=jump)


LOCATORS: Family[ErrorLocationMethod] = Family(
    "updating method", home="modallab.updating.error_location.methods"
)


@dataclass(frozen=True, eq=False)
class LocationResult:
    """Which members a measurement speaks against; the model stays as it is."""

    locator: str
    changes: Mapping[str, Mapping[int, float]]  # by part and member, to first order
    weights: Mapping[str, Mapping[int, float]]  # share of the difference that each stands for
    suspected: Mapping[str, tuple[int, ...]]  # members by part
    remaining: FloatArray  # (k,) share of the difference left by 1, 2, ... coefficients
    measured: FloatArray  # (n_modes,) Hz
    frequencies: FloatArray  # (n_modes,) Hz, of the model's modes that pair with these
    mac: FloatArray  # (n_modes,)
    rank: int
    condition_number: float

    def __post_init__(self) -> None:
        for name in ("remaining", "measured", "frequencies", "mac"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (None,), name=name))

    @property
    def coefficients(self) -> dict[str, dict[int, float]]:
        """What members' matrices would be multiplied by, to first order."""
        return {
            part: {member: Part(part).nominal + change for member, change in table.items()}
            for part, table in self.changes.items()
        }

"""What data say of the coefficients of an update, and do not."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab_client.models import FloatArray


@dataclass(frozen=True)
class Share:
    """A coefficient's share of a direction; the squares of all add up to one."""

    part: str
    members: tuple[int, ...]
    share: float


@dataclass(frozen=True)
class Direction:
    """Coefficients that may change together, with little or nothing of it in the data."""

    words: str
    standard_error: float | None  # of the relative change along it; None where data say nothing at all
    shares: tuple[Share, ...]

    def __str__(self) -> str:
        error = self.standard_error
        return self.words if error is None else f"{self.words} (standard error {error:.2g})"


@dataclass(frozen=True, eq=False)
class Identifiability:
    """How far the data alone determine the coefficients that were free to move."""

    rank: int
    condition_number: float | None
    singular_values: FloatArray
    unidentified: Mapping[str, tuple[int, ...]]  # part -> members
    directions: tuple[Direction, ...]


@dataclass(frozen=True)
class Quantity:
    """A property of some members in its own unit, before and after an update."""

    part: str
    members: tuple[int, ...]
    unit: str
    before: float
    after: float
    interval: tuple[float, float] | None  # that holds it with 95 %, by the data alone

    def __str__(self) -> str:
        where = ", ".join(map(str, self.members))
        held = f" (95 %: {ends(self.interval)})" if self.interval else ""
        return f"{self.part} of {where}: {self.after:.4g} {self.unit}, was {self.before:.4g}{held}"


@dataclass(frozen=True, eq=False)
class Responses:
    """How well an updated model's FRFs are the measured ones: mean squares over random error, 1 at best."""

    before: float
    after: float
    scatter: float  # standard deviation of such a mean, by random error alone
    n_lines: int
    band: tuple[float, float]  # Hz
    n_held_out: int  # lines that were looked at only afterwards
    held_out_before: float | None
    held_out_after: float | None
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    by_frf_before: FloatArray  # (n_out, n_in)
    by_frf_after: FloatArray

    def __str__(self) -> str:
        left = f"{self.after:.3g}, was {self.before:.3g}; 1 +- {self.scatter:.2g} by random error alone"
        return f"mean square of {self.n_lines} lines: {left}"


@dataclass(frozen=True, eq=False)
class Covariance:
    """The covariance of coefficients by the errors of the data."""

    coefficients: tuple[str, ...]  # (n_params,) as `mass of 3`
    intervals: FloatArray  # (n_params, 2) that hold each with 95 %
    covariance: FloatArray | None  # (n_params, n_params); None where there is nothing to judge errors by


@dataclass(frozen=True)
class Drawn:
    """A coefficient by its draws."""

    part: str
    members: tuple[int, ...]
    mean: float
    standard_deviation: float
    interval: tuple[float, float]  # between which 95 % lie
    effective: float  # independent draws that these are worth


@dataclass(frozen=True)
class Posterior:
    """What data and prior say of coefficients together, by draws."""

    n_draws: int
    n_chains: int
    acceptance: float
    coefficients: tuple[Drawn, ...]


@dataclass(frozen=True, eq=False)
class Sample:
    """Draws of coefficients from the posterior."""

    coefficients: tuple[str, ...]  # (n_free,) as `mass of 3`
    draws: FloatArray  # (n_draws, n_free)
    log_density: FloatArray  # (n_draws,)


def ends(interval: tuple[float, float] | None) -> str:
    """Return an interval as text, nothing for none."""
    return "" if interval is None else f"{interval[0]:.3g} to {interval[1]:.3g}"

"""Models that the curve of an unknown cause may follow, and their approximate parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.diagnosis.result import CurveModelName
from modallab.diagnosis.unknown.settings import UNKNOWN

ModelFunction = Callable[[FloatArray, FloatArray], ComplexArray]
"""Values (n_freq,) of a model at the shape parameters and omega (n_freq,) rad/s, for an amount of 1."""
StartFunction = Callable[[FloatArray, ComplexArray, FloatArray], Sequence[Sequence[float]]]
"""Starts of the shape parameters, all above zero, from omega, a curve and its standard error (n_freq,)."""


@dataclass(frozen=True)
class CurveModel:
    """A model amount x shape(omega), with the starts of its shape parameters."""

    name: CurveModelName
    """Name of the model in a result."""
    amount: str
    """Name of its amount."""
    unit: str
    """Unit of the amount."""
    shape: ModelFunction
    """The model for an amount of 1."""
    shape_units: Mapping[str, str]
    """Unit of each shape parameter by name."""
    starts: StartFunction
    """Starts of the shape parameters."""


@dataclass(frozen=True, eq=False)
class ModelEstimate:
    """A model near a curve."""

    model: CurveModel
    """The model."""
    amount: float
    """In the model's unit."""
    shapes: FloatArray
    """(n,) shape parameters."""
    chi_square: float
    """Sum of squares over the variance of the curve, real and imaginary part."""

    @property
    def values(self) -> FloatArray:
        """(1 + n,): the amount, then the shape parameters."""
        return np.concatenate([[self.amount], self.shapes])


def _constant(_: FloatArray, omega: FloatArray) -> ComplexArray:
    return np.ones(len(omega), complex)


def _mass(_: FloatArray, omega: FloatArray) -> ComplexArray:
    return np.asarray(-(omega**2), complex)


def _damper(_: FloatArray, omega: FloatArray) -> ComplexArray:
    return np.asarray(1j * omega, complex)


def _no_shape(_omega: FloatArray, _curve: ComplexArray, _error: FloatArray) -> list[list[float]]:
    return [[]]


def _over_band(omega: FloatArray) -> FloatArray:
    return np.geomspace(omega[0], omega[-1], UNKNOWN.starts)


def _oscillator(p: FloatArray, omega: FloatArray) -> ComplexArray:
    own = (2 * np.pi * p[0]) ** 2 * (1 + 1j * p[1])
    return np.asarray(-(omega**2) * own / (own - omega**2))


def _oscillator_starts(omega: FloatArray, _curve: ComplexArray, _error: FloatArray) -> list[list[float]]:
    return [[f, eta] for f in _over_band(omega) / (2 * np.pi) for eta in UNKNOWN.starting_loss_factors]


def _two_oscillators(p: FloatArray, omega: FloatArray) -> ComplexArray:
    return np.asarray(_oscillator(p[:2], omega) + p[4] * _oscillator(p[2:4], omega))


def _two_oscillator_starts(omega: FloatArray, curve: ComplexArray, error: FloatArray) -> list[list[float]]:
    """Return the oscillators of the rational function of omega^2 that is nearest to a curve."""
    poles, residues = two_poles(omega**2, curve / -(omega**2), error / omega**2)
    masses = residues.real / np.where(poles.real > 0, poles.real, np.inf)
    if not masses.prod() > 0:
        return []
    first, second = np.argsort(poles.real)
    found: list[float] = []
    for pole in poles[[first, second]]:
        loss_factor = max(pole.imag / pole.real, UNKNOWN.starting_loss_factors[0])
        found += [float(np.sqrt(pole.real)) / (2 * np.pi), float(loss_factor)]
    return [[*found, float(masses[second] / masses[first])]]


def two_poles(x: FloatArray, y: ComplexArray, error: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles and residues (2,) of y = sum residue_i/(pole_i - x).

    Reference: Sanathanan and Koerner, IEEE Trans. Automatic Control 8 (1963) 56-58.

    Parameters
    ----------
    x
        (n,).
    error
        (n,) standard error of y.
    """
    scale = float(x.max())
    x = x / scale
    denominator = np.ones(len(x), complex)
    for _ in range(UNKNOWN.denominator_steps):
        columns = np.stack([np.ones(len(x)), x, -y, -y * x], axis=1)
        weight = 1 / (error * np.abs(denominator))
        a0, a1, b0, b1 = np.linalg.lstsq(columns * weight[:, None], y * x**2 * weight, rcond=None)[0]
        denominator = b0 + b1 * x + x**2
    poles: ComplexArray = np.asarray(np.roots([1, b1, b0]), np.complex128)
    other = poles[::-1]
    difference = np.where(poles == other, np.inf, poles - other)
    residues: ComplexArray = np.asarray(-(a0 + a1 * poles) / difference * scale, np.complex128)
    return poles * scale, residues


def _delay_starts(omega: FloatArray, _curve: ComplexArray, _error: FloatArray) -> list[list[float]]:
    phases = np.linspace(UNKNOWN.shortest_delay, UNKNOWN.longest_delay, UNKNOWN.starts)
    return [[phase / omega[-1]] for phase in phases]


STIFFNESS_MODELS = (
    CurveModel(CurveModelName.SPRING, "stiffness", "N/m", _constant, {}, _no_shape),
    CurveModel(CurveModelName.MASS, "mass", "kg", _mass, {}, _no_shape),
    CurveModel(CurveModelName.DAMPER, "damping", "N s/m", _damper, {}, _no_shape),
    CurveModel(
        CurveModelName.HYSTERETIC_SPRING,
        "stiffness",
        "N/m",
        lambda p, w: np.full(len(w), 1 + 1j * p[0]),
        {"loss_factor": "1"},
        lambda *_: [[eta] for eta in UNKNOWN.starting_loss_factors],
    ),
    CurveModel(
        CurveModelName.SPRING_AND_DAMPER,
        "stiffness",
        "N/m",
        lambda p, w: 1 + 1j * w * p[0],
        {"time_constant": "s"},
        lambda w, *_: [[1 / each] for each in _over_band(w)],
    ),
    CurveModel(
        CurveModelName.POWER,
        "magnitude_at_1_rad_per_s",
        "N/m",
        lambda p, w: (1j * w) ** p[0],
        {"exponent": "1"},
        lambda *_: [[a] for a in (0.1, 0.5, 0.9, 1.5)],
    ),
    CurveModel(
        CurveModelName.OSCILLATOR,
        "mass",
        "kg",
        _oscillator,
        {"frequency": "Hz", "loss_factor": "1"},
        _oscillator_starts,
    ),
    CurveModel(
        CurveModelName.TWO_OSCILLATORS,
        "mass",
        "kg",
        _two_oscillators,
        {
            "frequency": "Hz",
            "loss_factor": "1",
            "second_frequency": "Hz",
            "second_loss_factor": "1",
            "mass_ratio": "1",
        },
        _two_oscillator_starts,
    ),
)
"""Models of a dynamic stiffness between a motion and the ground."""
FEEDBACK_MODELS = tuple(
    CurveModel(
        CurveModelName(f"delayed_{motion}_feedback"),
        "gain",
        unit,
        lambda p, w, power=power: (1j * w) ** power * np.exp(-1j * w * p[0]),  # type: ignore[misc]
        {"delay": "s"},
        _delay_starts,
    )
    for power, (motion, unit) in enumerate(
        (("displacement", "N/m"), ("velocity", "N s/m"), ("acceleration", "kg"))
    )
)
"""Models of a force by the motion of another DoF."""
GAIN_MODELS = (
    CurveModel(CurveModelName.GAIN, "gain", "1", _constant, {}, _no_shape),
    CurveModel(
        CurveModelName.FIRST_ORDER_HIGH_PASS,
        "gain",
        "1",
        lambda p, w: 1j * w / (1j * w + 2 * np.pi * p[0]),
        {"corner": "Hz"},
        lambda w, *_: [[f] for f in _over_band(w) / (2 * np.pi)],
    ),
    CurveModel(
        CurveModelName.FIRST_ORDER_LOW_PASS,
        "gain",
        "1",
        lambda p, w: 1 / (1 + 1j * w / (2 * np.pi * p[0])),
        {"corner": "Hz"},
        lambda w, *_: [[f] for f in _over_band(w) / (2 * np.pi)],
    ),
    CurveModel(
        CurveModelName.DELAY, "gain", "1", lambda p, w: np.exp(-1j * w * p[0]), {"delay": "s"}, _delay_starts
    ),
)
"""Models of a channel's whole gain, true over declared."""


def estimate(
    model: CurveModel, omega: FloatArray, curve: ComplexArray, error: FloatArray
) -> ModelEstimate | None:
    """Return the model that is nearest to a curve; None if it is near to none.

    Weighted least squares, the amount eliminated (variable projection); from the best of all starts.

    Parameters
    ----------
    omega
        (n_freq,) rad/s.
    curve
        (n_freq,) values.
    error
        (n_freq,) standard error of real and of imaginary part.
    """

    def amount(p: FloatArray) -> float:
        shape = model.shape(p, omega) / error
        size = max(float((np.abs(shape) ** 2).sum()), SAFE_SQUARED_DIVISOR)
        return float((shape.conj() @ (curve / error)).real) / size

    def misfit(logarithms: FloatArray) -> FloatArray:
        p = np.exp(logarithms)
        difference = (curve - amount(p) * model.shape(p, omega)) / error
        return np.concatenate([difference.real, difference.imag])

    starts = [np.log(np.array(start, float)) for start in model.starts(omega, curve, error)]
    if not starts:
        return None
    costs = [float(misfit(start) @ misfit(start)) for start in starts]
    best = starts[int(np.argmin(costs))]
    if len(best):
        near = best - UNKNOWN.range_of_shapes, best + UNKNOWN.range_of_shapes
        best = np.asarray(scipy.optimize.least_squares(misfit, best, bounds=near).x)
    shapes = np.exp(best)
    return ModelEstimate(model, amount(shapes), shapes, float(misfit(best) @ misfit(best)))

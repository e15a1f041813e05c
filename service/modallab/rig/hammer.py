"""Impact of a hammer: pulse, useful band, scatter from blow to blow."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.settings import HAMMER


def pulse_width(tip_stiffness: float, hammer_mass: float) -> float:
    """Return how long, s, a hammer's head touches a structure much heavier than itself: pi sqrt(m/k).

    Half a period of the head on the spring of its tip; the force is half a sine.

    Parameters
    ----------
    tip_stiffness
        N/m.
    hammer_mass
        kg.
    """
    return float(np.pi * np.sqrt(hammer_mass / tip_stiffness))


def pulse_spectrum(omega: FloatArray, width: float) -> ComplexArray:
    """Return the transform of half a sine that begins at time 0, over its value at 0 Hz, (n_freq,).

    cos(x) / (1 - (2x/pi)^2) exp(-i x), x = omega width / 2: zero first at 3/2 of 1/width.

    Parameters
    ----------
    omega
        (n_freq,) rad/s.
    width
        s.
    """
    x = omega * width / 2
    far = np.abs(2 * x / np.pi - 1) > HAMMER.series_distance
    shape = np.full(len(omega), np.pi / 4)  # where both cosine and denominator vanish
    shape[far] = np.cos(x[far]) / (1 - (2 * x[far] / np.pi) ** 2)
    return np.asarray(shape * np.exp(-1j * x))


def tilt_moments(scatter: float, n_lateral: int) -> tuple[float, float, float]:
    """Return mean and variance of a blow's share along its axis, and the variance of that across.

    A tilt to each side is normal, of standard deviation `scatter`, rad: E cos = exp(-s^2/2),
    E cos^2 = (1 + exp(-2 s^2))/2.
    """
    along = np.exp(-(scatter**2) / 2) ** max(n_lateral, 1)
    square = ((1 + np.exp(-2 * scatter**2)) / 2) ** max(n_lateral, 1)
    return float(along), float(square - along**2), float((1 - np.exp(-2 * scatter**2)) / 2)


def tilt_factors(
    scatter: float, n: int, n_lateral: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return the force components of n tilted blows along the axis (n,) and across it (n, n_lateral)."""
    angle = scatter * rng.standard_normal((n, max(n_lateral, 1)))
    return np.cos(angle).prod(axis=1), np.sin(angle)[:, :n_lateral]

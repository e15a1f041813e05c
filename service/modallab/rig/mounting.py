"""Mounting of accelerometers and their mounted resonance."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds


@dataclass(frozen=True)
class Mounting:
    """Mounted resonance of an accelerometer: its mass on the damped spring of the mounting."""

    frequency: float
    """Hz, mounted resonance."""
    loss: float
    """1, twice the damping ratio."""


# Typical of a general-purpose piezoelectric accelerometer; its own data sheet wins. Firm joints ring most.
MOUNTINGS = {
    "stud": Mounting(31e3, 0.03),
    "wax": Mounting(29e3, 0.05),
    "magnet": Mounting(7e3, 0.1),
}


def reading(ratio: FloatArray, loss: float) -> ComplexArray:
    """Return the reading over the true acceleration, (1 + i loss r)/(1 - r^2 + i loss r), at r = f/f_0.

    The motion of a mass on a viscously damped spring whose base moves (transmissibility): right at low
    frequencies, where the sensor was calibrated.
    """
    return np.asarray((1 + 1j * loss * ratio) / (1 - ratio**2 + 1j * loss * ratio))


def useful_frequency(frequency: float, deviation: float, loss: float = 0.0) -> float:
    """Return the frequency, Hz, up to which a reading is right within a relative deviation.

    From (1 + loss^2 r^2) / ((1 - r^2)^2 + loss^2 r^2) = (1 +- deviation)^2. Undamped, 10 % end at
    f_0 / 3.32 and 5 % at f_0 / 4.58; the rules of thumb f_0 / 3 and f_0 / 5 stand for 12.5 % and 4.2 %.

    Parameters
    ----------
    frequency
        Mounted resonance, Hz.
    deviation
        0.1 for 10 %.
    loss
        2 zeta of the mounting.

    Raises
    ------
    InvalidInputError
        If the deviation is not between 0 and 1.
    """
    if not 0 < deviation < 1:
        raise InvalidInputError(
            "a deviation lies between none and all", field="deviation", value=deviation, allowed=bounds(0, 1)
        )
    high, low = (1 + deviation) ** 2, (1 - deviation) ** 2
    over = _squared_ratios(high, loss)
    # Damped so much that it never reads that much too high, but falls.
    return float(frequency * np.sqrt(_squared_ratios(low, loss)[1] if np.isnan(over[0]) else over[0]))


def _squared_ratios(power: float, loss: float) -> tuple[float, float]:
    """Return both squared ratios f/f_0 at which a reading's square is a power; nan where there are none.

    The roots of power x^2 + (loss^2 (power - 1) - 2 power) x + power - 1, ascending.
    """
    half = 1 - loss**2 * (power - 1) / (2 * power)
    under_root = half**2 - (power - 1) / power
    if under_root < 0 or (power > 1 and half < 0):
        return np.nan, np.nan
    return float(half - np.sqrt(under_root)), float(half + np.sqrt(under_root))

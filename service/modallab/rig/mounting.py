"""Mounting of accelerometers and their mounted resonance."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds


@dataclass(frozen=True)
class Mounting:
    """Mounted resonance of an accelerometer: seismic mass on a damped spring."""

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
    """Return the reading over the true acceleration, 1/(1 - r^2 + i loss r), at r = f/f_0.

    The strain of a viscously damped spring under a mass whose base moves: right at low frequencies,
    where the sensor was calibrated.
    """
    return np.asarray(1 / (1 - ratio**2 + 1j * loss * ratio))


def useful_frequency(frequency: float, deviation: float, loss: float = 0.0) -> float:
    """Return the frequency, Hz, up to which a reading is right within a relative deviation.

    From (1 - r^2)^2 + loss^2 r^2 = (1 +- deviation)^-2. Undamped, 10 % end at f_0 / 3.32 and 5 % at
    f_0 / 4.58; the rules of thumb f_0 / 3 and f_0 / 5 stand for 12.5 % and 4.2 %.

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
    half = 1 - loss**2 / 2
    under_root = half**2 - 1 + (1 + deviation) ** -2
    if half > 0 and under_root >= 0:  # it rises to its resonance
        return float(frequency * np.sqrt(half - np.sqrt(under_root)))
    # Damped so much that it never reads that much too high, but falls.
    return float(frequency * np.sqrt(half + np.sqrt(half**2 - 1 + (1 - deviation) ** -2)))

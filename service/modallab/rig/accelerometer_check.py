"""Check of the accelerometers' useful frequency range."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.rig.mounting import reading, useful_frequency
from modallab.rig.settings import CHECK
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class AccelerometerCheck:
    """Error of the accelerometers at the top of the band, from their mounted resonance."""

    name: ClassVar[str] = "useful_range"
    rule: ClassVar[str] = "at the top of the band accelerometers read within 10 %"
    mounted_frequency: float
    """Hz, mounted resonance."""
    frequency_max: float
    """Hz, top of the band."""
    within_5_percent: float
    """Hz, frequency up to which the error is below 5 %."""
    within_10_percent: float
    """Hz, frequency up to which the error is below 10 %."""
    error_at_the_top: float
    """1, relative error at the top of the band."""

    @property
    def fulfilled(self) -> bool:
        """Whether the error is within the limit over the whole band."""
        return self.frequency_max <= self.within_10_percent


def accelerometer_checks(setup: RigSetup) -> tuple[AccelerometerCheck, ...]:
    """Return the check of the useful range; empty for ideal accelerometers.

    1/(1 - r^2 + i loss r) at r = f/f_0, exactly: f_0/3 and f_0/5 are rules of thumb for it.
    """
    mounting = setup.accelerometers.effective_mounting
    if mounting is None:
        return ()
    top = setup.analyser.frequency_max
    relative_reading = np.abs(reading(np.array([top / mounting.frequency]), mounting.loss))[0]
    limit_5_percent, limit_10_percent = (
        useful_frequency(mounting.frequency, share, mounting.loss)
        for share in (CHECK.strict_reading_tolerance, CHECK.reading_tolerance)
    )
    return (
        AccelerometerCheck(
            mounting.frequency, top, limit_5_percent, limit_10_percent, float(relative_reading) - 1
        ),
    )

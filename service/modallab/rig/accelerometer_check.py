"""Whether the band stays within the useful range of the accelerometers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.rig.mounting import reading, useful_frequency
from modallab.rig.settings import CHECK
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class AccelerometerCheck:
    """How far the band reaches into the mounted resonance."""

    name: ClassVar[str] = "useful_range"
    rule: ClassVar[str] = "at the top of the band accelerometers read within 10 %"
    mounted_frequency: float  # Hz
    frequency_max: float  # Hz
    within_5_percent: float  # Hz, up to which readings are
    within_10_percent: float  # Hz
    error_at_the_top: float  # relative, of the reading

    @property
    def fulfilled(self) -> bool:
        """Whether readings are right enough in all of the band."""
        return self.frequency_max <= self.within_10_percent


def accelerometer_checks(setup: RigSetup) -> tuple[AccelerometerCheck, ...]:
    """Return how the band lies to the accelerometers' useful range; nothing where they are ideal.

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

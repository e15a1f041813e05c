"""Checks of a stinger's resonances against the band: 1992 thesis, appendix D."""

from dataclasses import dataclass
from typing import ClassVar

from modallab.rig.setup import RigSetup
from modallab.rig.stinger import StingerRod, axial_frequency


@dataclass(frozen=True)
class StingerBendingCheck:
    """First bending frequency of the stinger over the top of the band."""

    name: ClassVar[str] = "stinger_bending"
    rule: ClassVar[str] = "the stinger's first bending frequency is above the band"
    bending_frequency: float
    """Hz, first bending frequency between two clamps."""
    frequency_max: float
    """Hz, top of the band."""
    ratio: float
    """1, the first over the second."""

    @property
    def fulfilled(self) -> bool:
        """Whether it does not bend within the band."""
        return self.ratio > 1


@dataclass(frozen=True)
class StingerAxialCheck:
    """Resonance of the armature on stinger and force gauge over the top of the band."""

    name: ClassVar[str] = "stinger_axial"
    rule: ClassVar[str] = "the armature's resonance on the stinger is above the band"
    axial_frequency: float
    """Hz, resonance of the armature on stinger and gauge, structure fixed."""
    frequency_max: float
    """Hz, top of the band."""
    ratio: float
    """1, the first over the second."""

    @property
    def fulfilled(self) -> bool:
        """Whether the source's force arrives within the band."""
        return self.ratio > 1


def stinger_bending_check(setup: RigSetup) -> StingerBendingCheck | None:
    """Return the bending check; None unless a rod is declared."""
    if not isinstance(setup.stinger, StingerRod):
        return None
    frequency, band = setup.stinger.bending_frequency, setup.analyser.frequency_max
    return StingerBendingCheck(frequency, band, frequency / band)


def stinger_axial_check(setup: RigSetup) -> StingerAxialCheck | None:
    """Return the axial check; None if mass or spring is ideal."""
    declared = (setup.stinger.axial_stiffness if setup.stinger else None, setup.force_transducer.stiffness)
    compliance = sum(1 / stiffness for stiffness in declared if stiffness)
    if compliance == 0 or setup.exciter.armature_mass == 0:
        return None
    band = setup.analyser.frequency_max
    frequency = axial_frequency(1 / compliance, setup.exciter.armature_mass)
    return StingerAxialCheck(frequency, band, frequency / band)


def stinger_checks(setup: RigSetup) -> tuple[StingerBendingCheck | StingerAxialCheck, ...]:
    """Return the checks that the declared stinger, gauge and armature allow."""
    candidates = (stinger_bending_check(setup), stinger_axial_check(setup))
    return tuple(check for check in candidates if check is not None)

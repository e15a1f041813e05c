"""Settings of the effects, with unit, meaning and origin."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class OscillatorScan(Settings):
    """Scan of an attached oscillator."""

    band_step: float = setting(
        0.03,
        unit="1",
        doc="step of trial frequencies over the top of the band",
        derived="oscillator of that frequency in every part of the band",
    )


@dataclass(frozen=True)
class ResonanceScan(Settings):
    """Scan of the frequency of a resonance in or above the band."""

    lowest: float = setting(
        0.03,
        unit="1",
        doc="lowest trial frequency over the top of the band",
        derived="of a lower resonance little more is seen",
    )
    step: float = setting(
        0.015,
        unit="1",
        doc="relative step of trial frequencies in the band",
        derived="a half-power bandwidth of loss factor 0.015",
    )
    highest: float = setting(
        4.0,
        unit="1",
        doc="highest trial frequency over the top of the band",
        derived="a higher resonance changes the band by less than a sixteenth",
    )
    outer_step: float = setting(
        0.1,
        unit="1",
        doc="relative step of trial frequencies above the band",
        derived="there the response is smooth",
    )

    @property
    def frequencies(self) -> FloatArray:
        """(n,) trial frequencies over the top of the band."""
        inner = np.arange(np.log(self.lowest), 0.0, self.step)
        outer = np.arange(0.0, np.log(self.highest), self.outer_step)
        return np.asarray(np.exp(np.concatenate([inner, outer])))


@dataclass(frozen=True)
class StingerScan(ResonanceScan):
    """Scan of the axial stiffness of a stinger, by the resonance of the armature on it."""

    stiffnesses: tuple[float, ...] = setting(
        (3e4, 1e5, 3e5, 1e6, 3e6, 1e7, 1e8),
        unit="N/m",
        doc="trial stiffnesses without an armature's mass",
        derived="from a thin wire to a short rod",
    )


@dataclass(frozen=True)
class MountingScan(ResonanceScan):
    """Scan of the mounted resonance of accelerometers."""

    step: float = setting(
        0.04,
        unit="1",
        doc="relative step of trial frequencies in the band",
        derived="a half-power bandwidth of loss factor 0.04",
    )
    far: tuple[float, ...] = setting(
        (8.0, 16.0, 32.0),
        unit="1",
        doc="further trial frequencies over the top of the band",
        derived="readings 1.6, 0.4 and 0.1 % too high at its top",
    )


@dataclass(frozen=True)
class MountingSettings(Settings):
    """Accelerometers on their mounting."""

    rigid_frequency: float = setting(
        2e4,
        unit="Hz",
        doc="mounted resonance above which an accelerometer loads the structure as a rigid one",
        derived="at 2 kHz its mass then differs by 1 %",
    )


@dataclass(frozen=True)
class CableScan(Settings):
    """Scan of the mass of accelerometer cables."""

    growth: float = setting(
        3.0,
        doc="trial growth of the mass over the structure, over the mass at its corner",
        derived="a cable hangs over most of the structure's size; none is tried beside it",
    )


@dataclass(frozen=True)
class JointScan(Settings):
    """Scan of a joint's flexibility."""

    decades: tuple[float, float] = setting(
        (-1.5, 2.5),
        unit="1",
        doc="decimal logarithms of the flexibility over that of a member's end",
        tuned="simulated tests of the suite",
    )
    n_values: int = setting(9, unit="values", doc="trial flexibilities", derived="two a decade")


@dataclass(frozen=True)
class SupportScan(Settings):
    """Scan of the flexibility of a support."""

    decades_along: tuple[float, float] = setting(
        (-2.0, 5.0),
        unit="1",
        doc="decimal logarithms of the flexibility over that of the members there, along a direction",
        derived="from a hundredth of a member's to that of a bar of fifty members, which goes with the cube",
    )
    decades_about: tuple[float, float] = setting(
        (-2.0, 3.0),
        unit="1",
        doc="the same about an axis",
        derived="to that of a bar of several hundred members, which goes with the length",
    )

    @property
    def along(self) -> FloatArray:
        """(n,) trial flexibilities over that of the members, two a decade."""
        return np.logspace(*self.decades_along, 15)

    @property
    def about(self) -> FloatArray:
        """(n,) the same about an axis."""
        return np.logspace(*self.decades_about, 11)


@dataclass(frozen=True)
class MixUpSettings(Settings):
    """Accelerometers at another place than the log book says."""

    misplacements: tuple[float, ...] = setting(
        (0.05, 0.25, 0.6, 1.0, 1.5, 2.0),
        unit="1",
        doc="trial distances of a misplaced accelerometer over the mean length of the members at its node",
        derived="a slip of the hand; the next node; the node after",
    )
    paired_channels: int = setting(
        250,
        unit="channels",
        doc="channels up to which every pair may be exchanged",
        derived="31,125 pairs, which are named in less than a second",
    )


@dataclass(frozen=True)
class MainsSettings(Settings):
    """Mains hum."""

    odd_harmonics: tuple[int, ...] = setting(
        (1, 3, 5, 7),
        unit="1",
        doc="harmonics of a current of which both half waves are distorted alike",
        derived="a square wave",
    )
    harmonic_start: float = setting(
        0.3,
        unit="1",
        doc="size of harmonics, as their parameters count it, from which fits start",
        derived="the power goes with its square, whose slope is zero at zero",
    )
    frequencies: tuple[float, ...] = setting(
        (50.0, 60.0), unit="Hz", doc="mains frequencies", derived="national grids"
    )


@dataclass(frozen=True)
class OverloadSettings(Settings):
    """Overload of the converter."""

    max_level: float = setting(
        100.0,
        unit="1",
        doc="range over rms at which nothing is clipped",
        derived="no sample of a Gaussian signal is so large",
    )


@dataclass(frozen=True)
class FrictionScan(Settings):
    """Scan of dry friction."""

    sticking_ratio: float = setting(
        0.1,
        unit="1",
        doc="sticking velocity over the rms of the velocity",
        tuned="simulated tests of the suite",
    )
    least_sticking_ratio: float = setting(
        0.005,
        unit="1",
        doc="least sticking velocity of simulated tests, over the rms of the velocity",
        derived="a motion is slower during 0.4 % of its time",
    )


@dataclass(frozen=True)
class ArmatureScan(Settings):
    """Scan of the armature's mass."""

    max_mass: float = setting(5.0, unit="kg", doc="highest trial mass", derived="bound of the parameter")
    values_per_decade: int = setting(
        12,
        unit="values",
        doc="trial masses a decade",
        derived="a step of a fifth stays within one local minimum of the force spectrum's misfit",
    )
    n_values: int = setting(64, unit="values", doc="trial masses", derived="down to some tens of milligrams")


@dataclass(frozen=True)
class DoubleHitScan(Settings):
    """Scan of a second blow."""

    n_delays: int = setting(
        100,
        unit="values",
        doc="trial delays, half a period of the band's top apart",
        derived="between two of them the ripple stays in phase over the band",
    )


@dataclass(frozen=True)
class SuspensionPlaces(Settings):
    """Pairs of elastic bands."""

    largest_offset: float = setting(
        0.03,
        doc="distance of a band from the mirror image of the other over the extent of the structure",
        derived="half an element of a beam of 17; two bands a quarter of the extent off the centre carry "
        "weights 12 % apart",
    )


@dataclass(frozen=True)
class IntegrationScan(Settings):
    """Scan and suspicion of an integrated response."""

    integrations: tuple[float, ...] = setting(
        (-2.0, -1.0, 1.0, 2.0),
        unit="1",
        doc="trial numbers of integrations",
        derived="between acceleration, velocity and displacement",
    )
    factors: tuple[float, ...] = setting(
        (1.0, 10.0, 40.0, 1e3, 1e4, 1e6),
        unit="1",
        doc="trial factors of units",
        derived="none; g; inches; mm; mm in place of g; micrometres; between them the logarithm is fitted",
    )
    nearness: float = setting(
        0.5,
        unit="1",
        doc="difference of logarithms of FRFs below which they are alike",
        derived="that of FRFs of shifted resonances is less, except at resonances and antiresonances",
    )
    least_share: float = setting(
        0.5, unit="1", doc="share of lines up to which an integration is excluded", derived="half of them"
    )
    least_lines: int = setting(
        8, unit="lines", doc="lines without which a response says nothing", derived="of fewer, half is chance"
    )


@dataclass(frozen=True)
class TransverseScan(Settings):
    """Scan of the most sensitive direction across an accelerometer's axis."""

    angle: float = setting(
        np.pi / 3, unit="rad", doc="trial angle to either side of 0", derived="half a turn in three steps"
    )


OSCILLATOR_SCAN = OscillatorScan()
STINGER_SCAN = StingerScan()
MOUNTING_SCAN = MountingScan()
CABLE_SCAN = CableScan()
MOUNTING = MountingSettings()
JOINT_SCAN = JointScan()
SUPPORT_SCAN = SupportScan()
MIX_UP = MixUpSettings()
MAINS = MainsSettings()
OVERLOAD = OverloadSettings()
FRICTION_SCAN = FrictionScan()
ARMATURE_SCAN = ArmatureScan()
DOUBLE_HIT_SCAN = DoubleHitScan()
SUSPENSION = SuspensionPlaces()
INTEGRATION = IntegrationScan()
TRANSVERSE_SCAN = TransverseScan()

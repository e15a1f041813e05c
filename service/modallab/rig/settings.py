"""Settings of the rig: chain, exciters and checks, with unit, meaning and origin."""

from dataclasses import dataclass

import numpy as np

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class AcquisitionSettings(Settings):
    """Sampling of the analyser."""

    rate_ratio: float = setting(
        2.56,
        unit="1",
        doc="sample rate over the top of the band",
        derived="convention of FFT analysers: room for the roll-off of the anti-alias filter",
    )
    line_tolerance: float = setting(
        0.02,
        unit="lines",
        doc="distance of a stated frequency from a line of the record",
        derived="frequencies in single precision are off by 0.06 lines at the millionth line, less before",
    )
    window_end_bounds: tuple[float, float] = setting(
        (1e-6, 0.999),
        unit="1",
        doc="least and largest height of an exponential window at the end of the record",
        derived="a window that ends at 1 does not decay; below, the end of a record is lost in rounding",
    )


@dataclass(frozen=True)
class SourceSettings(Settings):
    """A simulated test whose analyser or source are not declared."""

    averages: int = setting(
        100, unit="averages", doc="averages of a simulated test", derived="default of `Analyser`"
    )
    level: float = setting(1.0, unit="N", doc="rms of the source of a simulated test", derived="unit force")
    out_of_band: float = setting(
        1e-12,
        unit="1",
        doc="spectrum of a source outside its band over that inside",
        derived="120 dB, the floor of a generator; keeps the expected FRF finite",
    )
    min_band_lines: int = setting(
        4, unit="lines", doc="least width of the band of a source", derived="bound of input"
    )


@dataclass(frozen=True)
class ChainSettings(Settings):
    """Frequency responses of the measuring chain."""

    dc_line_fraction: float = setting(
        1e-3,
        unit="lines",
        doc="frequency at which the limit of inertance at 0 Hz is taken",
        derived="within 1e-6 of the limit; omega^2 is still above the rounding of a free body's damping",
    )
    frequency_block: int = setting(
        2048, unit="frequencies", doc="frequencies solved for in one call", derived="cache size"
    )
    cached_receptances: int = setting(
        2**19, unit="values", doc="size of the latest receptances that are kept", derived="memory: 8 MB"
    )


@dataclass(frozen=True)
class CheckSettings(Settings):
    """Checks of a rig."""

    reading_tolerance: float = setting(
        0.1,
        unit="1",
        doc="error of a reading at the top of the band",
        derived="the 10 % rule of thumb for accelerometers",
    )
    strict_reading_tolerance: float = setting(
        0.05,
        unit="1",
        doc="error of a reading that a check reports beside it",
        derived="the 5 % rule of thumb for accelerometers",
    )
    rigid_elastic_ratio: float = setting(
        0.1,
        unit="1",
        doc="highest rigid-body frequency over the first elastic one",
        derived="Ewins, Modal Testing (2000), chapter 3",
    )
    initial_frequency: float = setting(
        1.0,
        unit="Hz",
        doc="first upper limit of the modes that are solved for",
        derived="only the cost depends on it",
    )
    frequency_step: float = setting(
        4.0,
        unit="1",
        doc="factor on that limit while modes are missing",
        derived="only the cost depends on it",
    )


@dataclass(frozen=True)
class ChangeSettings(Settings):
    """Comparison of two log books."""

    relative_tolerance: float = setting(
        1e-6,
        unit="1",
        doc="relative difference within which two numbers are the same",
        derived="numbers that were written as text and read again",
    )
    min_factor: float = setting(
        1e-6,
        unit="1",
        doc="lowest factor on level or averages",
        derived="bound of input, far beyond any test",
    )
    max_factor: float = setting(
        1e6,
        unit="1",
        doc="highest factor on level or averages",
        derived="bound of input, far beyond any test",
    )
    max_mass: float = setting(
        100.0, unit="kg", doc="highest added mass", derived="bound of input, far beyond any test"
    )


@dataclass(frozen=True)
class DriveSettings(Settings):
    """Moving parts of an exciter."""

    joint_loss_factor: float = setting(
        0.01,
        unit="1",
        doc="loss factor of stinger and force gauge",
        derived="keeps the resonance of armature and structure finite",
    )
    rigid_rate: float = setting(
        2 * np.pi * 1e6,
        unit="rad/s",
        doc="rate above which a mass on its joint moves as if joined rigidly",
        derived="far above any band",
    )


@dataclass(frozen=True)
class HammerSettings(Settings):
    """Impact of a hammer."""

    slope_step: float = setting(
        1e-4,
        unit="m",
        doc="step of the central difference of shape functions at a node",
        derived="truncation and rounding errors are both below 1e-6",
    )
    series_distance: float = setting(
        1e-6,
        unit="1",
        doc="distance from the removable singularity of the pulse spectrum",
        derived="the limit is used within it",
    )


@dataclass(frozen=True)
class StingerSettings(Settings):
    """Bounds of a declared stinger."""

    min_stiffness: float = setting(
        1.0,
        unit="N/m",
        doc="lowest axial stiffness",
        derived="an armature of 100 g resonates on it at 0.5 Hz, below any band",
    )
    max_stiffness: float = setting(
        1e12, unit="N/m", doc="highest axial stiffness, which counts as rigid", derived="bound of input"
    )
    max_bending_stiffness: float = setting(
        1e7, unit="N m/rad", doc="highest bending stiffness", derived="bound of input"
    )
    min_length: float = setting(1e-3, unit="m", doc="lowest length", derived="bound of input")
    max_length: float = setting(
        1e3, unit="m", doc="highest length", derived="no lateral stiffness is left there"
    )
    max_mass: float = setting(5.0, unit="kg", doc="highest mass", derived="bound of input")
    clamped_root: float = setting(
        4.730040744862704,
        unit="1",
        doc="first root of cosh x cos x = 1",
        derived="Bernoulli beam clamped at both ends",
    )


ACQUISITION = AcquisitionSettings()
SOURCE = SourceSettings()
CHAIN = ChainSettings()
CHECK = CheckSettings()
CHANGE = ChangeSettings()
DRIVE = DriveSettings()
HAMMER = HammerSettings()
STINGER = StingerSettings()

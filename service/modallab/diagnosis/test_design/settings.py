"""Settings of the design of further tests."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class FollowUpSettings(Settings):
    """Further tests that are considered."""

    level_factor: float = setting(
        3.0,
        doc="force level over that of the first test",
        derived="a cubic force is then 27 times as large against 3 times of a linear one",
    )
    averages_factor: float = setting(
        10.0,
        doc="number of averages over that of the first test",
        derived="random errors fall by the square root: to a third",
    )
    refinement: int = setting(
        2,
        doc="factor of the frequency resolution or of the band",
        derived="smallest whole factor: other lines, twice the modes",
    )
    added_mass: float = setting(
        0.05,
        unit="kg",
        doc="known mass added to the structure",
        derived="shifts the modes of a beam of some kilograms by per cents; common in a laboratory",
    )
    n_drives: int = setting(
        3,
        unit="drive points",
        doc="other drive points considered",
        derived="computing time",
    )


@dataclass(frozen=True)
class SeparationSettings(Settings):
    """Expected separation of two explanations by a further test."""

    certain: float = setting(
        5.0,
        unit="standard deviations",
        doc="separation that distinguishes two explanations",
        derived="5 sigma: chance alone exceeds it once in 3.5 million",
    )
    useful: float = setting(
        1.0,
        unit="standard deviations",
        doc="separation below which a test is not proposed",
        derived="the random error of the test itself",
    )
    difference_step: float = setting(
        1e-4,
        doc="relative step of a parameter for finite differences",
        derived="far above rounding, far below the curvature of any effect",
    )


@dataclass(frozen=True)
class RivalSettings(Settings):
    """Rivals for which a further test is sought."""

    certain: float = setting(
        0.95,
        doc="probability above which an explanation has no probable rival",
        derived="usual 95 % level",
    )
    possible: float = setting(
        0.01,
        doc="least probability of a rival that a test is designed for",
        derived="the usual 1 % level",
    )
    max_rivals: int = setting(
        3,
        unit="rivals",
        doc="rivals that a test is designed for",
        derived="computing time",
    )


FOLLOW_UP = FollowUpSettings()
SEPARATION = SeparationSettings()
RIVALS = RivalSettings()

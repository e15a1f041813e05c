"""Settings of the leakage correction of global methods."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class LeakageCorrectionSettings(Settings):
    """Correction of lines with leakage by the nearest mode."""

    resonance_error: float = setting(
        0.02,
        doc="Relative error of a corrected line at resonance.",
        tuned="chosen by judgement; test_leakage_correction.py passes with half, fails with twice the value",
    )
    smallest_flank_error: float = setting(
        0.1,
        unit="errors at resonance",
        doc="Least relative error of a corrected line.",
        tuned="chosen by judgement; test_leakage_correction.py passes with half and with twice the value",
    )
    disagreement_errors: float = setting(
        3.0,
        unit="standard errors",
        doc="Difference of a corrected line from the modes that reduces its weight.",
        derived="3 sigma: one of 370 by chance",
    )


@dataclass(frozen=True)
class LeakedModeSettings(Settings):
    """Standard errors and bias of modes from corrected lines."""

    step: float = setting(
        0.1,
        unit="standard errors",
        doc="Step of the correcting modes in a difference quotient.",
        derived="far inside the linear range",
    )
    largest_relative_error: float = setting(
        0.3,
        unit="loss factors",
        doc="Error of a correcting mode up to which it is propagated linearly.",
        derived="a larger one exceeds the linear range",
    )
    remaining_fraction: float = setting(
        0.02,
        doc="Part of the corrected loss factor that may remain.",
        tuned="free beam without random error, modes 0.3 to 5 lines wide: up to 2 %, half below 0.1 %",
    )
    remaining_shift: float = setting(
        0.002,
        unit="lines",
        doc="Shift of a frequency that may remain.",
        tuned="the same: up to 0.0023 lines, 0.0008 for modes wider than one line",
    )
    lines: int = setting(
        20,
        unit="lines",
        doc="Lines to either side in the covariance of a mode.",
        tuned="sampled tests with H1 and H2: with 12 modal constants by H1 scatter less, with 32 more",
    )
    narrow: float = setting(
        1.0,
        unit="lines",
        doc="Bandwidth below which a modal constant is no surer than that of the reference mode.",
        tuned="the same tests: constants of modes 0.3 and 0.5 lines wide by H2",
    )
    half_power_widths: float = setting(
        3.0,
        unit="half-power bandwidths",
        doc="The same where it is more.",
        tuned="halved and doubled, no test of this room fails",
    )
    largest_lines: int = setting(
        32,
        unit="lines",
        doc="Largest number of lines to either side.",
        derived="cost: quadratic in the lines",
    )
    minimum_lines: int = setting(
        4, unit="lines", doc="Least number of lines.", derived="a mode and a constant, and one line more"
    )


LEAKAGE_CORRECTION = LeakageCorrectionSettings()
LEAKED_MODES = LeakedModeSettings()

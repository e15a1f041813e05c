"""Settings of the extraction as a whole: shares of progress, notes and plots."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ProgressShareSettings(Settings):
    """Shares of the computing time, as progress is reported."""

    structural_fit: float = setting(
        0.6, doc="Extraction by the structural damping model.", tuned="durations of tests with many FRFs"
    )
    single_modes: float = setting(
        0.1, doc="Single-mode fits of some FRFs.", tuned="durations of tests with many FRFs"
    )
    single_modes_leaked: float = setting(
        0.6, doc="Single-mode fits of all FRFs with leakage.", tuned="durations of tests with many FRFs"
    )
    fits: float = setting(0.95, doc="All fits of a global method.", tuned="durations of tests with many FRFs")


@dataclass(frozen=True)
class ExtractionNoteSettings(Settings):
    """Notes and exclusions of the extraction."""

    listed_peaks: int = setting(
        8,
        unit="peaks",
        doc="Peaks without a mode that are listed; more are counted.",
        derived="length of a note",
    )
    smeared_lines: int = setting(
        3,
        unit="lines",
        doc="Lines to either side of a resonance that leakage distorts.",
        derived="main lobe of a Hann window and its first side lobe",
    )
    consistency_frfs: int = setting(
        24,
        unit="FRFs",
        doc="FRFs by which the consistency of frequencies is tested.",
        derived="cost: a test of significance needs no more",
    )


@dataclass(frozen=True)
class FitPlotSettings(Settings):
    """Plot of a fit."""

    curve_points: int = setting(
        201, unit="points", doc="Points of a fitted curve.", derived="smooth in a plot"
    )


@dataclass(frozen=True)
class SummarySettings(Settings):
    """Summary of flags and notes."""

    flags: int = setting(
        3,
        unit="flags",
        doc="Flags of a modal model that are named first.",
        derived="the number that the API states for `main_flags`",
    )
    notes_alike: int = setting(
        3,
        unit="notes",
        doc="Notes that differ in numbers only and are all listed.",
        tuned="chosen by judgement; test_summary.py fails with half and passes with twice the value",
    )


PROGRESS_SHARES = ProgressShareSettings()
NOTES = ExtractionNoteSettings()
FIT_PLOT = FitPlotSettings()
SUMMARY = SummarySettings()

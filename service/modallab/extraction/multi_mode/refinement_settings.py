"""Settings of the elimination, search and merging of modes of global methods."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class RefinementSettings(Settings):
    """Elimination of modes that the FRFs do not show."""

    mode_errors: float = setting(
        5.0,
        unit="standard errors",
        doc="Least modal constant.",
        derived="noise alone reaches it once in 300,000 FRFs",
    )
    largest_error: float = setting(
        0.5,
        unit="bandwidths or lines",
        doc="Standard error of a frequency up to which a pole is a mode.",
        derived="a mode with a larger error may be noise",
    )
    iterations: int = setting(12, doc="Eliminations.", tuned="halved and doubled, no test of this room fails")
    later_share: float = setting(
        0.4, doc="Share of the remaining time for later fits.", derived="the first fit takes longest"
    )
    reweighted_fits: int = setting(
        2,
        doc="Fits with weights from residuals where coherence is unknown.",
        tuned="with 1 and 4, no test of this room fails",
    )
    upper_start: float = setting(
        1.2,
        unit="upper limits",
        doc="Start of a pole above the range.",
        tuned="from 1.05 to 1.8, no test of this room fails",
    )
    lower_start: float = setting(
        0.8,
        unit="lower limits",
        doc="Start of a pole below the range.",
        tuned="from 0.4 to 0.92, no test of this room fails",
    )
    starting_loss_factor: float = setting(
        0.01,
        doc="Loss factor of these poles at the start.",
        tuned="halved and doubled, no test of this room fails",
    )


@dataclass(frozen=True)
class ResidualPoleSettings(Settings):
    """Search for poles in the residual of a fit of all modes."""

    searches: int = setting(
        4,
        doc="Searches, each in the residual of the fit before.",
        derived="one for each mode of a close group",
    )
    trials: int = setting(
        3,
        doc="Fits of one search, each without the rejected poles of the one before.",
        tuned="chosen by judgement; test_residual_poles.py passes with 2 and with 6",
    )
    first_share: float = setting(
        0.7, doc="Share of the time for the first fit.", tuned="durations with 222 FRFs"
    )
    most_candidates: int = setting(
        8, unit="poles", doc="Largest number of candidates of a search.", derived="cost: a search follows"
    )
    false_poles: float = setting(
        1e-6,
        doc="Probability that noise alone gives a candidate anywhere.",
        derived="a candidate costs three fits; what becomes a mode is judged by `mode_errors`",
    )
    damping_ratio: float = setting(
        3.0,
        unit="loss factors",
        doc="Largest ratio of a candidate's loss factor to the extreme ones of the known modes.",
        derived="modes of a structure are damped alike; the fit determines the loss factor",
    )
    width_step: float = setting(
        1.6,
        unit="bandwidths",
        doc="Ratio of successive bandwidths.",
        derived="a bandwidth wrong by its root loses 3 % of the decrease of the squared residual",
    )
    group: float = setting(
        0.25,
        unit="bandwidths",
        doc="Largest group of lines that are summed first.",
        derived="a resonance turns by less than a seventh of its circle in it",
    )
    reach: float = setting(
        4.0,
        unit="bandwidths",
        doc="Lines to either side that a candidate is fitted to.",
        derived="beyond them lies 1/13 of a resonance's power",
    )
    least_reach: int = setting(
        4, unit="lines", doc="The same where it is more.", derived="noise is estimated from the lines"
    )
    edge_lines: float = setting(
        3.0,
        unit="lines",
        doc="Distance of a candidate from either end of the range.",
        derived="a resonance needs lines on either flank",
    )
    closest: float = setting(
        0.5,
        unit="half-power bandwidths",
        doc="Least distance of a new mode from the others.",
        derived="closer poles describe one mode of a drifting frequency as well; a chart must show them",
    )
    noise_ratio: float = setting(
        2.0,
        unit="variances of a line",
        doc="Mean squared residual around a new mode up to which it is noise.",
        derived="variances of lines are estimated within a factor of two",
    )
    quiet_share: float = setting(
        0.25,
        unit="lines",
        doc="Part of the lines, the quietest, by whose residual noise is judged.",
        derived="modes that are missing take up less than the rest",
    )
    largest_excess: float = setting(
        1.5,
        doc="Decrease of the squared residual by a resonance, over that with independent noise.",
        tuned="white noise: 1.0; an exponential window that falls to 0.01: 2.7 to 10",
    )


@dataclass(frozen=True)
class SplitModeSettings(Settings):
    """Poles that are one mode whose frequency moves during the test."""

    bandwidths: float = setting(
        0.25,
        unit="half-power bandwidths",
        doc="Distance of two poles below which they are one mode if their shapes are equal.",
        tuned="simulated drifts of 0.006 and 0.02 % with modes of loss factor 4e-4: 0.05 to 0.36",
    )
    least_mac: float = setting(
        0.99,
        doc="MAC of two equal shapes.",
        derived="a mean over the drift leaves all FRFs the same; noise of a close pair takes 1 % at most",
    )
    least_frfs: int = setting(
        4,
        unit="FRFs",
        doc="Number of FRFs that tell shapes.",
        derived="by chance two of 4 are as similar once in 1000",
    )


@dataclass(frozen=True)
class CoincidentModeSettings(Settings):
    """Modes with equal poles."""

    pole_errors: float = setting(
        3.0,
        unit="standard errors",
        doc="Difference of poles that is significant.",
        derived="3 sigma: one of 370 by chance",
    )
    smallest_extent: float = setting(
        1e-3,
        doc="Ratio of singular values of the shapes at the drive points that determines the scale.",
        tuned="halved and doubled, no test of this room fails",
    )


REFINEMENT = RefinementSettings()
RESIDUAL_POLES = ResidualPoleSettings()
SPLIT_MODES = SplitModeSettings()
COINCIDENT_MODES = CoincidentModeSettings()

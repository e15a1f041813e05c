"""Settings of global methods: stabilisation chart, selection of modes, common fit, standard errors."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

SUITE = "chosen by judgement; not studied"
MEMORY = "memory: 32 MB an array"


@dataclass(frozen=True)
class MatrixFractionSettings(Settings):
    """Matrix fractions in the z domain."""

    least_arc: float = setting(
        0.8,
        unit="circles",
        doc="Least part of the unit circle that the band covers.",
        derived="on the whole circle both ends of the band would meet, but they differ",
    )
    smallest_eigenvalue_ratio: float = setting(
        0.05,
        doc="Ratio of extreme eigenvalues of the normal equations by which the arc grows with the order.",
        derived="on an arc of capacity c the ratio is about c^(2 n) at order n",
    )
    largest_power_ratio: float = setting(
        100.0,
        unit="median powers",
        doc="Largest weighted power of an FRF.",
        derived="an underestimated error of one FRF must not suppress the others",
    )
    smallest_gain: float = setting(
        1e-8,
        unit="largest powers",
        doc="Least weight of a line.",
        derived="a lower weight would have no effect",
    )
    compensated_bias: float = setting(
        0.75,
        doc="Part of the bias by noise that is subtracted from the normal equations.",
        derived="the bias of poles decreases with it; with all of it noise poles would be stable",
    )
    lines_per_order: int = setting(
        2,
        unit="lines",
        doc="Least number of lines for each order.",
        derived="otherwise noise of lines is fitted",
    )
    frfs_in_memory: int = setting(32, unit="FRFs", doc="FRFs that are treated together.", derived="memory")
    largest_inputs: int = setting(
        6,
        unit="inputs",
        doc="Largest number of inputs of a poly-reference fit.",
        derived="memory of the participation factors' normal equations",
    )


@dataclass(frozen=True)
class ChartSettings(Settings):
    """Orders of the stabilisation chart, and tracks of poles over the orders."""

    orders_per_peak: int = setting(
        4,
        unit="orders",
        doc="Orders for each peak.",
        derived="two for its pole, the others for residuals and noise",
    )
    residual_orders: int = setting(16, unit="orders", doc="Further orders for residuals.", tuned=SUITE)
    smallest_limit: int = setting(4, unit="orders", doc="Least highest order.", tuned=SUITE)
    lines_per_order: int = setting(
        3,
        unit="lines",
        doc="Least number of lines for each order.",
        derived="fewer lines than unknowns fit any polynomial",
    )
    track_distance: float = setting(
        0.5,
        unit="decay rates",
        doc="Largest shift of a pole from one order to the next.",
        derived="poles of a structure shift less",
    )
    track_distance_lines: float = setting(0.1, unit="lines", doc="The same where it is larger.", tuned=SUITE)


@dataclass(frozen=True)
class SelectionSettings(Settings):
    """Selection of modes from the tracks of a stabilisation chart."""

    stable_level: int = setting(
        2,
        doc="Level of a stable pole.",
        derived="levels of `stabilise`: 2 is stable in frequency and damping",
    )
    minimum_stable: int = setting(5, unit="poles", doc="Least number of stable poles.", tuned=SUITE)
    minimum_stable_fraction: float = setting(
        1 / 3, unit="orders", doc="Least number of stable poles in a short chart.", tuned=SUITE
    )
    stable_fraction: float = setting(
        0.5, unit="orders", doc="Least part of the orders from the first stable pole on.", tuned=SUITE
    )
    noted_stable: int = setting(
        3, unit="poles", doc="Stable poles from which a rejected track is noted.", tuned=SUITE
    )
    minimum_strength: float = setting(
        4.0,
        unit="standard errors",
        doc="Least strength of a pole with many FRFs.",
        tuned="simulated noise: the strongest noise poles reach 3",
    )
    few_frf_factor: float = setting(
        3.0,
        unit="FRFs",
        doc="Increase of that limit with few FRFs.",
        tuned="simulated noise: with one FRF noise poles are twice as strong",
    )
    smallest_width: float = setting(
        0.005,
        unit="lines",
        doc="Least half-power bandwidth.",
        derived="a feature of one line alone is hum or a wrong value",
    )
    largest_loss_factor: float = setting(
        0.4, doc="Largest loss factor.", derived="no resonance: the motion decays within two periods"
    )
    pair_distance: float = setting(
        3.0,
        unit="half-power bandwidths",
        doc="Distance within which two modes are a pair.",
        derived="within it the resonance circles overlap",
    )


@dataclass(frozen=True)
class UniformGridSettings(Settings):
    """Uniform grid for lines of any spacing."""

    grid_tolerance: float = setting(
        0.01, unit="least spacings", doc="Largest distance of a line from its grid point.", tuned=SUITE
    )
    rounding_tolerance: float = setting(
        0.05,
        unit="spacings",
        doc="Largest distance of equally spaced lines from their places.",
        derived="frequencies written with few digits",
    )
    largest_subdivision: int = setting(
        8,
        unit="parts of the least spacing",
        doc="Finest grid.",
        derived="a grid point is then off by a sixteenth of the least spacing at most",
    )
    largest_grid: int = setting(2**16, unit="grid points", doc="Largest grid.", derived="memory")


@dataclass(frozen=True)
class RangeSettings(Settings):
    """Modes of one frequency range."""

    largest_dofs: int = setting(
        48,
        unit="DoFs",
        doc="DoFs above which a pole finder gets principal components.",
        derived="cost of the pole finder",
    )
    pole_share: float = setting(
        0.05, doc="Share of the time for poles.", tuned="durations of tests with many FRFs"
    )
    match_distance: float = setting(
        0.5,
        unit="half-power bandwidths",
        doc="Largest distance of a mode from the pole that it was started at.",
        tuned=SUITE,
    )
    rigid_body_lines: float = setting(
        3.0,
        unit="lines",
        doc="Frequency below which a pole is no mode.",
        derived="a resonance needs a line on either flank and one that is not distorted by 0 Hz",
    )
    largest_width_ratio: float = setting(
        5.0,
        unit="bandwidths of the other mode",
        doc="Largest bandwidth of a mode that only overlaps another one's peak.",
        derived="a broader pole below a resonance is a residual: modes of a pair have similar damping",
    )
    match_spacing: float = setting(0.25, unit="lines", doc="Least bandwidth in that distance.", tuned=SUITE)


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
    iterations: int = setting(12, doc="Eliminations.", tuned=SUITE)
    later_share: float = setting(
        0.4, doc="Share of the remaining time for later fits.", derived="the first fit takes longest"
    )
    reweighted_fits: int = setting(
        2, doc="Fits with weights from residuals where coherence is unknown.", tuned=SUITE
    )
    upper_start: float = setting(
        1.2, unit="upper limits", doc="Start of a pole above the range.", tuned=SUITE
    )
    lower_start: float = setting(
        0.8, unit="lower limits", doc="Start of a pole below the range.", tuned=SUITE
    )
    starting_loss_factor: float = setting(0.01, doc="Loss factor of these poles at the start.", tuned=SUITE)


@dataclass(frozen=True)
class ResidualPoleSettings(Settings):
    """Search for poles in the residual of a fit of all modes."""

    searches: int = setting(
        4,
        doc="Searches, each in the residual of the fit before.",
        derived="one for each mode of a close group",
    )
    trials: int = setting(
        3, doc="Fits of one search, each without the rejected poles of the one before.", tuned=SUITE
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
class ModalFitSettings(Settings):
    """Gauss-Newton steps on the eigenvalues of all modes."""

    iterations: int = setting(
        40, doc="Largest number of steps.", derived="four to eight are taken from a pole finder's start"
    )
    usual_iterations: int = setting(
        6, doc="Steps after which half of the progress is reported.", tuned="starts from a pole finder"
    )
    convergence: float = setting(
        0.001,
        unit="standard errors",
        doc="Largest step of a pole in the range at which the fit ends.",
        derived="far below the random error",
    )
    residual_gain: float = setting(
        1e-4,
        unit="misfits",
        doc="Decrease of the misfit for which modes outside the range are moved further.",
        derived="a smaller one changes the residuals by less than a ten-thousandth",
    )
    last_step: float = setting(
        0.1,
        unit="standard errors",
        doc="Largest step of a pole in the range that may be the last.",
        derived="the error left by a Gauss-Newton step is quadratic in it",
    )
    smallest_gain: float = setting(
        1.0,
        unit="random errors per unknown",
        doc="Decrease of the misfit below which such a step is the last.",
        derived="a smaller decrease is insignificant",
    )
    similar_share: float = setting(
        0.5, doc="Share of the time for steps with similar weights.", tuned="durations with 222 FRFs"
    )
    insensitivity: float = setting(
        1e-9,
        unit="misfits",
        doc="Change of the misfit that is rounding.",
        derived="rounding of the sums over lines, and of directions that the lines do not determine",
    )
    largest_step: float = setting(
        0.5,
        unit="imaginary parts of the eigenvalue",
        doc="Largest step.",
        derived="beyond it the linearisation does not hold",
    )
    lowest_frequency: float = setting(
        0.3,
        unit="lower limits",
        doc="Least frequency of a pole below the range.",
        derived="a pole further below is a mass line and would drift",
    )
    highest_frequency: float = setting(
        1.4,
        unit="upper limits",
        doc="Largest frequency of a pole above the range.",
        derived="a pole further above is a constant and would drift",
    )
    largest_loss_factor: float = setting(
        1.9,
        doc="Largest loss factor of a viscous pole.",
        derived="from 2 on the pole is real and has no modal constant",
    )
    first_damping: float = setting(
        1e-4,
        unit="diagonal entries",
        doc="Levenberg-Marquardt damping at the start.",
        derived="Marquardt's scaled form: a nearly full Gauss-Newton step",
    )
    damping_increase: float = setting(10.0, doc="Factor after a failure.", derived="Marquardt (1963)")
    damping_decrease: float = setting(0.1, doc="Factor after a success.", derived="Marquardt (1963)")


@dataclass(frozen=True)
class ProjectionSettings(Settings):
    """Sums over lines, and residuals of a range."""

    products_in_memory: int = setting(
        2**22, unit="numbers", doc="Size of a block of products.", derived=MEMORY
    )
    least_group: int = setting(
        4,
        unit="lines",
        doc="Mean size of groups of lines from which sums are taken by groups.",
        derived="a group takes as long as a few lines",
    )
    similar_lines: int = setting(
        16,
        unit="lines",
        doc="Largest group of lines with one weight in the first steps of a fit.",
        derived="cost of the sums; the last steps have the weights of the lines, so that only their number"
        " depends on it",
    )
    wide_range: float = setting(
        0.5,
        unit="upper limits",
        doc="Lower limit of a range below which out-of-band modes are not constant in it.",
        tuned=SUITE,
    )
    many_lines: int = setting(
        64, unit="lines", doc="Lines above which a range determines out-of-band poles.", tuned=SUITE
    )
    fixed_poles: tuple[float, ...] = setting(
        (1.5,),
        unit="upper limits",
        doc="Frequencies of undamped poles above a wide range.",
        derived="with a constant they represent all higher modes to 3 %, except for the next one",
    )


@dataclass(frozen=True)
class ModalCovarianceSettings(Settings):
    """Standard errors of the common fit."""

    common_noise_deviations: float = setting(
        3.0,
        unit="standard deviations",
        doc="Correlation of FRFs that is significant.",
        derived="3 sigma: one of 370 by chance",
    )
    simultaneous_part: float = setting(
        0.5,
        doc="Correlation of FRFs, over that by noise of one force, from which all were recorded together.",
        derived="two runs of as many FRFs each leave less than half of the pairs with one force",
    )
    frfs_in_memory: int = setting(32, unit="FRFs", doc="FRFs that are treated together.", derived="memory")


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
        tuned=SUITE,
    )


@dataclass(frozen=True)
class LeakageCorrectionSettings(Settings):
    """Correction of lines with leakage by the nearest mode."""

    resonance_error: float = setting(
        0.02, doc="Relative error of a corrected line at resonance.", tuned=SUITE
    )
    smallest_flank_error: float = setting(
        0.1, unit="errors at resonance", doc="Least relative error of a corrected line.", tuned=SUITE
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
        3.0, unit="half-power bandwidths", doc="The same where it is more.", tuned=SUITE
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


MATRIX_FRACTION = MatrixFractionSettings()
CHART = ChartSettings()
SELECTION = SelectionSettings()
UNIFORM_GRID = UniformGridSettings()
RANGES = RangeSettings()
REFINEMENT = RefinementSettings()
RESIDUAL_POLES = ResidualPoleSettings()
SPLIT_MODES = SplitModeSettings()
MODAL_FIT = ModalFitSettings()
PROJECTION = ProjectionSettings()
MODAL_COVARIANCE = ModalCovarianceSettings()
COINCIDENT_MODES = CoincidentModeSettings()
LEAKAGE_CORRECTION = LeakageCorrectionSettings()
LEAKED_MODES = LeakedModeSettings()

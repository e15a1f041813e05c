"""Settings of pole finders, the stabilisation chart and the ranges of global methods."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


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
    residual_orders: int = setting(
        16,
        unit="orders",
        doc="Further orders for residuals.",
        tuned="chosen by judgement; test_frequency_ranges.py states orders, fails with half and with twice",
    )
    smallest_limit: int = setting(
        4,
        unit="orders",
        doc="Least highest order.",
        tuned="chosen by judgement; test_frequency_ranges.py passes with half and with twice the value",
    )
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
    track_distance_lines: float = setting(
        0.1,
        unit="lines",
        doc="The same where it is larger.",
        tuned="chosen by judgement; test_pole_tracks.py passes with half and with twice the value",
    )


@dataclass(frozen=True)
class SelectionSettings(Settings):
    """Selection of modes from the tracks of a stabilisation chart."""

    stable_level: int = setting(
        2,
        doc="Level of a stable pole.",
        derived="levels of `stabilise`: 2 is stable in frequency and damping",
    )
    minimum_stable: int = setting(
        5,
        unit="poles",
        doc="Least number of stable poles.",
        tuned="chosen by judgement; test_mode_selection.py fails with half and with twice the value",
    )
    minimum_stable_fraction: float = setting(
        1 / 3,
        unit="orders",
        doc="Least number of stable poles in a short chart.",
        tuned="chosen by judgement; test_mode_selection.py fails with half and passes with twice the value",
    )
    stable_fraction: float = setting(
        0.5,
        unit="orders",
        doc="Least part of the orders from the first stable pole on.",
        tuned="chosen by judgement; test_mode_selection.py fails with half and passes with twice the value",
    )
    noted_stable: int = setting(
        3,
        unit="poles",
        doc="Stable poles from which a rejected track is noted.",
        tuned="chosen by judgement; test_mode_selection.py passes with 2 and fails with 6",
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
        0.01,
        unit="least spacings",
        doc="Largest distance of a line from its grid point.",
        tuned="chosen by judgement; test_uniform_grid.py passes with half and with twice the value",
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
        tuned="halved and doubled, no test of this room fails",
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
    match_spacing: float = setting(
        0.25,
        unit="lines",
        doc="Least bandwidth in that distance.",
        tuned="halved and doubled, no test of this room fails",
    )


MATRIX_FRACTION = MatrixFractionSettings()
CHART = ChartSettings()
SELECTION = SelectionSettings()
UNIFORM_GRID = UniformGridSettings()
RANGES = RangeSettings()

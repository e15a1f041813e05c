"""Settings of residuals: floors of random errors, weights of the logarithm, correlation of lines."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

TESTS = "simulated tests of the suite"


@dataclass(frozen=True)
class RandomErrorSettings(Settings):
    """Random errors of measured averages."""

    prediction_error: float = setting(
        1e-6,
        doc="relative numerical error of a prediction, the least error of any measured value",
        derived="numerical error of the prediction itself",
    )
    noise_average: int = setting(
        7,
        unit="lines",
        doc="lines of the running mean in which the noise of the force is estimated",
        tuned=TESTS,
    )
    noise_quantile: float = setting(
        0.1,
        doc="share of the lines whose estimate of the noise of the force is lower than the one used",
        tuned=TESTS,
    )
    min_averages: int = setting(
        2,
        unit="averages",
        doc="averages up to which coherence says nothing of the random error",
        derived="the variance of H1 has n - 2 in its denominator (Goodman 1963)",
    )
    window_reach: int = setting(
        3,
        unit="lines",
        doc="lines beside the end of a source's band to which a window carries what lies beyond",
        derived="main lobe of a Hann window, and one line for an end that is not sharp",
    )
    line_tolerance: float = setting(
        0.01, unit="lines", doc="rounding of the frequency of a line", derived="far below one line"
    )
    window_samples: int = setting(
        256,
        unit="samples",
        doc="samples of a window for its correlation length",
        derived="exact for sums of cosines at this length",
    )


@dataclass(frozen=True)
class MainsLineSettings(Settings):
    """Lines of the mains in tests of unknown rigs."""

    frequencies: tuple[float, ...] = setting(
        (50.0, 60.0), unit="Hz", doc="mains frequencies", derived="national grids"
    )
    max_order: int = setting(
        7, unit="1", doc="highest harmonic", derived="those of a square wave, as of the effect"
    )
    lines_beside: int = setting(
        9, unit="lines", doc="lines on either side that tell the level without hum", tuned=TESTS
    )
    least_beside: int = setting(
        4, unit="lines", doc="lines that tell a level, at least", derived="a median of two on either side"
    )
    tolerance: float = setting(
        0.6, unit="lines", doc="lines by which the mains may be off", derived="half a line, and rounding"
    )
    least_ratio: float = setting(
        10.0,
        unit="1",
        doc="power of hum over that of the lines beside, at least",
        derived="of ten averages one of a million lines is as loud by chance",
    )
    frf_error: float = setting(
        100.0,
        unit="1",
        doc="relative error of an FRF where both channels hum",
        derived="hum a hundred times the signal: such a line tells nothing of the FRF",
    )
    unknown_share: float = setting(
        0.5,
        unit="1",
        doc="share of hum in the power of a force whose spectrum nobody gave",
        derived="as much as signal",
    )
    largest_share: float = setting(
        0.9,
        unit="1",
        doc="largest share of hum in the power of a force",
        derived="keeps its logarithm finite",
    )


@dataclass(frozen=True)
class ResidualSettings(Settings):
    """Whitened residuals of FRFs."""

    logarithm_limit: float = setting(
        0.02,
        doc="squared relative error of H1 at which the logarithm gives way to the relative difference",
        tuned=TESTS,
    )
    min_freedom: float = setting(
        0.1,
        unit="degrees of freedom",
        doc="least number of degrees of freedom of the variance that comes from a measured coherence",
        derived="keeps the scatter finite at three averages or fewer",
    )


@dataclass(frozen=True)
class LineCorrelationSettings(Settings):
    """Correlation of residuals from line to line: Newey and West, Econometrica 55 (1987), 703-708."""

    pooled_lags: int = setting(
        12,
        unit="lines",
        doc="lag at which Bartlett's taper ends, where one correlation holds for all lines of a part",
        tuned=TESTS,
    )
    score_lags: int = setting(
        8,
        unit="lines",
        doc="lag at which the taper ends, where every line enters with its own score",
        tuned=TESTS,
    )
    leakage_range: int = setting(
        4,
        doc="fraction 1/n of the band up to which correlation by leakage is sought",
        tuned=TESTS,
    )
    leakage_extension: float = setting(
        1.5,
        doc="taper's end over the farthest lag with a significant correlation",
        tuned=TESTS,
    )
    significance: float = setting(
        2.0,
        unit="sqrt(log10(n) / n)",
        doc="correlation of n lines above which it is not chance",
        derived="rule of Politis, Journal of Nonparametric Statistics 15 (2003), 467",
    )
    leverage_lines: int = setting(
        5,
        unit="lines",
        doc="lines that a window mixes, over which the leverage is summed",
        tuned=TESTS,
    )
    max_leverage: float = setting(
        0.7,
        doc="leverage up to which a residual is corrected for it (HC3)",
        tuned=TESTS,
    )


@dataclass(frozen=True)
class NoiseReferenceSettings(Settings):
    """Noise of the force channels between two readings of its ratio."""

    least_change: float = setting(
        1e-3,
        doc="change of the mean force, over itself, below which both readings are the same",
        derived="a thousandth of a variance shows in two million independent data",
    )
    tolerance: float = setting(
        1e-9, doc="last step of the fitted share", derived="smooth for differences of 1e-4"
    )
    max_iterations: int = setting(
        30, unit="iterations", doc="largest number of steps", derived="10 are enough mostly"
    )


@dataclass(frozen=True)
class H1BiasSettings(Settings):
    """Fit of the share of a free noise of the force that biases H1."""

    tolerance: float = setting(
        1e-9, doc="last step of the fitted share", derived="smooth for differences of 1e-4"
    )
    max_iterations: int = setting(
        30, unit="iterations", doc="largest number of steps", derived="5 are enough mostly"
    )


@dataclass(frozen=True)
class FreeLevelSettings(Settings):
    """Fits of levels that no log book declares."""

    max_functions: int = setting(
        8,
        unit="functions",
        doc="B-splines of the spectrum of an unknown source",
        derived="wide beside a resonance, as amplifiers and noise generators are smooth",
    )
    min_functions: int = setting(
        4, unit="functions", doc="least number of cubic B-splines", derived="degree 3"
    )
    lines_per_function: int = setting(
        12, unit="lines", doc="measured lines for each function, at least", derived="few data are taken up"
    )
    noise_functions: int = setting(
        6,
        unit="functions",
        doc="B-splines of the noise of a channel over the logarithm of frequency",
        derived="an octave and more of three decades each: wide beside a resonance",
    )
    noise_slope: float = setting(
        2.0,
        doc="difference of neighbouring coefficients of a noise spectrum's logarithm, one standard deviation",
        derived="1/f^2 over three decades is 14 over five differences",
    )
    shape_error: float = setting(
        0.023,
        doc="largest deviation of the logarithm of a source's power from its B-splines that is no effect",
        tuned="0.1 dB of power: eighty times what the splines leave of a cosine pulse (3e-4)",
    )
    initial_quantile: float = setting(
        0.1, doc="share of the lines below the first guess of a noise", derived="only the cost depends on it"
    )
    least_noise: float = setting(
        1e-14, doc="least noise over the spectrum of a channel", derived="rounding of a coherence"
    )
    least_curvature: float = setting(
        1e-6, doc="least curvature by the noise of the force", derived="keeps its step finite"
    )
    max_step: float = setting(3.0, doc="largest step of a logarithm", derived="only the cost depends on it")
    short_step: float = setting(
        1.0,
        doc="largest Newton step of a logarithm, above which a Gauss-Newton step replaces it",
        derived="a factor of e: only the cost depends on it",
    )
    last_step: float = setting(
        1e-4,
        doc="largest step of a logarithm that ends a fit",
        derived="its square, the error after a Newton step, is small beside differences of 1e-4",
    )
    near_step: float = setting(
        0.01,
        doc="the same of a prediction near another whose noise is known, for a derivative",
        derived="its square is a hundredth of the change that it ends",
    )
    coarse_step: float = setting(
        0.1,
        doc="the same of a coarse prediction",
        derived="its square is a tenth of the random error of a line",
    )
    least_share: float = setting(
        1e-3, doc="least share of a step that is tried", derived="only the cost depends on it"
    )
    max_iterations: int = setting(
        60, unit="iterations", doc="largest number of steps", derived="10 are enough mostly"
    )
    tolerance: float = setting(
        1e-13, doc="relative gain of a step that ends a fit", derived="smooth for differences of 1e-4"
    )


H1_BIAS = H1BiasSettings()
MAINS_LINES = MainsLineSettings()
RANDOM_ERROR = RandomErrorSettings()
FREE_LEVELS = FreeLevelSettings()
NOISE_REFERENCE = NoiseReferenceSettings()
RESIDUAL = ResidualSettings()
LINE_CORRELATION = LineCorrelationSettings()

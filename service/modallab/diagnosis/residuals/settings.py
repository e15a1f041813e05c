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
    window_samples: int = setting(
        256,
        unit="samples",
        doc="samples of a window for its correlation length",
        derived="exact for sums of cosines at this length",
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


RANDOM_ERROR = RandomErrorSettings()
RESIDUAL = ResidualSettings()
LINE_CORRELATION = LineCorrelationSettings()

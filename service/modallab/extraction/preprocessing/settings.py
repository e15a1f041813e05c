"""Settings of the preprocessing of FRFs: bands, windows of lines, leakage and noise."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class BandSettings(Settings):
    """Detection of resonances in the mode indicator."""

    prominence: float = setting(
        0.6,
        unit="decades of power",
        doc="Least prominence of a peak of the indicator.",
        derived="6 dB: between neighbouring resonances the indicator dips further, by random error less",
    )
    false_peak_probability: float = setting(
        0.01,
        doc="Probability that noise alone has the coherence that is required at a peak.",
        derived="significance level of 1 %",
    )
    largest_coherence_threshold: float = setting(
        0.9,
        doc="Upper bound of the coherence that is required, which few averages would raise to 1.",
        tuned="chosen by judgement; test_bands.py passes with half and with twice the value",
    )


@dataclass(frozen=True)
class CommonPeakSettings(Settings):
    """Distinction of resonances from peaks of noise by their agreement between FRFs."""

    minimum_frfs: int = setting(
        3, unit="FRFs", doc="Least number of FRFs.", derived="of two, neither has a majority over the other"
    )
    match_distance: float = setting(
        0.1,
        unit="half intervals between peaks of an FRF",
        doc="Largest distance of a peak of an FRF from a peak of the indicator that counts as the same.",
        derived="one peak in ten of any FRF lies so near by chance",
    )
    chance_probability: float = setting(
        0.011,
        doc="Largest binomial probability of the number of FRFs that match, for a peak to be common.",
        derived="of three FRFs both others must match: 0.1 squared, and a margin for rounding",
    )
    neighbours: int = setting(
        8,
        unit="peaks",
        doc="Peaks to one side that represent noise there.",
        tuned="test_common_peaks.py: with half as many, peaks of noise are "
        "taken for modes; with twice as many it passes",
    )
    minimum_uncommon: int = setting(
        6,
        unit="peaks",
        doc="Least number of these that are not common to the FRFs, for the range to be one of noise.",
        derived="fewer may be local modes",
    )


@dataclass(frozen=True)
class FitWindowSettings(Settings):
    """Choice of the lines of a single-mode fit."""

    largest_window: int = setting(
        96,
        unit="lines",
        doc="Most lines that the bandwidth alone asks for; of a wider window every k-th line is used.",
        derived="cost: beyond, Dobson's pairs of lines take longer than the lines add information",
    )
    peak_search_level: float = setting(
        0.01,
        doc="Part of the indicator's peak down to which the peak of each FRF is searched for.",
        tuned="chosen by judgement; test_fit_windows.py passes with half and with twice the value",
    )
    tie_offset: float = setting(
        0.25,
        unit="lines",
        doc="Shift of the peak towards the higher neighbour when distances of lines are ranked.",
        derived="any number between 0 and 0.5 avoids two lines at the same distance",
    )


@dataclass(frozen=True)
class LeakageSettings(Settings):
    """Leakage of one mode through a window, in closed form."""

    minimum_samples: int = setting(
        256,
        unit="samples",
        doc="Least number of samples of a window.",
        derived="the autocorrelation of a window is smooth: this many give it to 1e-5",
    )
    minimum_half_width: float = setting(
        1e-3,
        unit="lines",
        doc="Least imaginary part of the pole of structure and armature.",
        derived="keeps a fit that is not yet stable on the damped side, below any width that lines resolve",
    )
    quadrature_nodes: int = setting(
        96,
        unit="nodes",
        doc="Gauss-Legendre nodes over the lag.",
        derived="96 nodes integrate up to about 60 turns of the exponential, so as many lines away",
    )
    remaining_fraction: float = setting(
        0.05,
        doc="Part of the shift by leakage that the correction may leave, as it is exact for one mode and a "
        "smooth residual only.",
        tuned="free beam without random error: 0.1 to 3 % of loss factors remain at modes 0.3 to 1.5 lines"
        " wide, 2 to 7 % at 1.9 lines, medians over eleven FRFs; up to 26 % at 0.2 lines, by feedback",
    )


@dataclass(frozen=True)
class LeakedLineSettings(Settings):
    """Covariance of leaked lines."""

    pairs_in_memory: int = setting(
        2**18, unit="pairs of lines", doc="Pairs that are treated together.", derived="memory: 4 MiB an array"
    )


@dataclass(frozen=True)
class LineNoiseSettings(Settings):
    """Variance of the random error of lines."""

    neighbours: int = setting(
        33,
        unit="lines",
        doc="Lines of a group with one factor of weights from residuals.",
        derived="a mean square of 33 complex lines scatters by 17 %; such weights lose 3 % of precision",
    )
    quiet_fraction: float = setting(
        0.25,
        doc="Part of the lines at least whose fourth difference is noise alone.",
        tuned="tests of preprocessing and test_modal_fit.py pass from a quarter to twice the value",
    )
    parts: int = setting(
        8,
        unit="parts of the range",
        doc="Parts whose noise is compared to find white noise.",
        tuned="tests of preprocessing pass with 2 to 8, not with 16: more than a range of 12 lines has",
    )
    largest_level_scatter: float = setting(
        1.0,
        unit="ln of power",
        doc="Standard deviation of the level over these parts up to which noise is white.",
        tuned="simulated tests: white noise scatters by 0.2, curvature of exact FRFs by 3",
    )
    minimum_averages: float = setting(
        3.0,
        unit="averages",
        doc="Number of averages above which the bias n/(n - 2) of the coherence is corrected.",
        derived="at three averages the correction is a factor of three, below it has no meaning at two",
    )


@dataclass(frozen=True)
class CorrelatedLineSettings(Settings):
    """Lines whose errors the window of the records correlates."""

    farthest: int = setting(
        64,
        unit="lines",
        doc="Distance of lines from which on their correlation is taken as periodic.",
        derived="an exponential window that falls to 0.01 leaves a correlation of 0.02, one to 1e-6 of 0.07",
    )


@dataclass(frozen=True)
class LowCoherenceSettings(Settings):
    """Note on modes at lines of low coherence."""

    threshold: float = setting(
        0.3,
        doc="Median coherence near a mode below which a note is given.",
        derived="H1 and H2 differ by one over the coherence, a factor of three",
    )


@dataclass(frozen=True)
class NoiseBiasSettings(Settings):
    """Separation of noise of the force from noise of the responses."""

    minimum_coherence: float = setting(
        0.05,
        doc="Coherence below which a line does not separate the two kinds of noise.",
        tuned="test_noise_bias.py passes with 0.005 to 0.4",
    )
    iterations: int = setting(
        12,
        doc="Iterations of the reweighted least squares.",
        derived="convergence after a few, with a margin",
    )
    quiet_line_divisor: int = setting(
        4,
        doc="One line in so many, those of least leakage, determines the noise of the force.",
        tuned="chosen by judgement; test_noise_bias.py passes with half and with twice the value",
    )
    relative_uncertainty: float = setting(
        0.2,
        doc="Part of the bias correction that may be wrong, at its worst lines.",
        tuned="test_noise_bias.py, test_random_errors.py and test_extract.py pass with 0.02 to 0.8",
    )


@dataclass(frozen=True)
class ReciprocitySettings(Settings):
    """Limits of a departure from reciprocity."""

    misfit_deviations: float = setting(
        5.0,
        unit="standard deviations",
        doc="Excess of the mean squared normalised difference over 1 that is significant.",
        derived="lines of one test are not wholly independent: more than 3 sigma",
    )
    mode_standard_errors: float = setting(
        3.0,
        unit="standard errors",
        doc="Departure of the ratio of two modal constants from 1 that is significant.",
        derived="3 sigma: one of 370 by chance",
    )


@dataclass(frozen=True)
class ResponseSettings(Settings):
    """Admissible FRFs."""

    largest_receptance: float = setting(
        1e60,
        unit="m/N",
        doc="Largest modulus, and one over the smallest largest modulus.",
        derived="fourth powers stay within the range of a double",
    )


BANDS = BandSettings()
COMMON_PEAKS = CommonPeakSettings()
CORRELATED_LINES = CorrelatedLineSettings()
FIT_WINDOWS = FitWindowSettings()
LEAKAGE = LeakageSettings()
LEAKED_LINES = LeakedLineSettings()
LINE_NOISE = LineNoiseSettings()
LOW_COHERENCE = LowCoherenceSettings()
NOISE_BIAS = NoiseBiasSettings()
RECIPROCITY = ReciprocitySettings()
RESPONSES = ResponseSettings()

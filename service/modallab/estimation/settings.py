"""Settings of the estimation of spectra and frequency response functions."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class SpectrumSettings(Settings):
    """Averaging, windows and the input matrix."""

    batch_samples: int = setting(
        2**17,
        unit="samples",
        doc="samples of one batch of Fourier transforms",
        derived="the processor's cache: larger batches run at the speed of memory",
    )
    window_samples: int = setting(
        4096,
        unit="samples",
        doc="samples of a window for its mean square and its overlap with itself",
        derived="exact for sums of cosines at this length",
    )
    force_taper: float = setting(
        0.1,
        doc="fraction of a force window over which it falls to zero",
        derived="a smooth end, short beside the open part",
    )
    max_input_condition: float = setting(
        1e12,
        doc="condition number of the input matrix beyond which forces count as dependent",
        derived="H1 is then rounding",
    )


SPECTRUM = SpectrumSettings()


@dataclass(frozen=True)
class ClippingSettings(Settings):
    """Spectra of clipped Gaussian signals."""

    hermite_orders: tuple[int, ...] = setting(
        (3, 5, 7, 9, 11),
        doc="Hermite orders of the distortion that are computed; the remainder goes with the next one",
        tuned="simulated tests of the suite",
    )
    max_level: float = setting(
        30.0,
        unit="standard deviations",
        doc="clipping level beyond which nothing is clipped",
        derived="no Gaussian sample in double precision is as large",
    )


CLIPPING = ClippingSettings()


@dataclass(frozen=True)
class ForceNoiseSettings(Settings):
    """Separation of the noise of the force channel from that of the responses."""

    min_coherence: float = setting(
        1e-6, doc="coherence below which there is no response at all", derived="a floor of divisions"
    )
    relative_rounding: float = setting(
        1e-6,
        doc="amplitude of noise over that of the force that counts as rounding",
        derived="noise 120 dB below the force is that of the arithmetic",
    )
    outlier_ratio: float = setting(
        2.0,
        doc="incoherent power over both fitted noises above which a line is left out of the fit",
        tuned="simulated tests of the suite",
    )
    iterations: int = setting(
        50, unit="iterations", doc="alternating least-squares steps", tuned="simulated tests of the suite"
    )
    initial_quantile: float = setting(
        0.1,
        doc="quantile of the lines' incoherent power from which the fit starts",
        tuned="simulated tests of the suite",
    )
    max_common_fraction: float = setting(
        0.95,
        doc="largest fraction of a variance that is attributed to the common noise",
        derived="the fraction is an estimate, and the independent remainder must count",
    )
    min_signal_to_noise: float = setting(
        0.1,
        doc="least power of the force signal over its noise",
        derived="keeps a force positive where noise seems to be all of it",
    )


FORCE_NOISE = ForceNoiseSettings()


@dataclass(frozen=True)
class LineScatterSettings(Settings):
    """Scatter of neighbouring lines about a local model."""

    stretch_lines: int = setting(
        17,
        unit="lines",
        doc="lines of a stretch",
        tuned="simulated tests of the suite: the estimate is 5 to 10 % off with 13, 2 to 5 % with 17",
    )
    order: int = setting(
        2, doc="order of numerator and denominator of the model", derived="two resonances in a stretch"
    )
    reweightings: int = setting(
        3, doc="fits with the weights of the fit before", derived="converged where the noise is small"
    )
    least_denominator: float = setting(
        1e-3, doc="denominator below which it takes no part in a weight", derived="a pole on a line"
    )
    min_coherence: float = setting(
        0.1, doc="coherence below which a line is not used", derived="the random error of H1 is of its size"
    )
    max_stretches: int = setting(
        8000, unit="stretches", doc="stretches of all FRFs that are used", derived="0.5 % of the estimate"
    )
    min_stretches: int = setting(
        6, unit="stretches", doc="stretches of each FRF that an estimate asks for", derived="10 to 20 %"
    )
    groups: int = setting(
        10, unit="groups", doc="groups of stretches whose scatter tells the error", derived="known to 25 %"
    )
    plausible_scatter: float = setting(
        3.0,
        unit="standard deviations",
        doc="difference of a stretch's scatter from the expected one above which it does not tell the window",
        derived="one stretch in some hundred, where the local model holds",
    )
    window_significance: float = setting(
        1.0,
        unit="standard errors",
        doc="log-likelihood ratio from which on another window than the declared one is taken",
        derived="chance 0.16 where both are equally likely; of 128 tests of an independent simulator the "
        "true window was the likelier one in all, by 1.1 or more",
    )


LINE_SCATTER = LineScatterSettings()


@dataclass(frozen=True)
class ErrorCorrelationSettings(Settings):
    """Correlation of the errors of neighbouring lines."""

    max_fits: int = setting(
        1000, unit="fits", doc="local fits that are compared", derived="12,000 residuals for two parameters"
    )
    ends: tuple[float, ...] = setting(
        (0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 1e-4),
        doc="heights of an exponential window at its end that are tried",
        derived="those in use, a factor of three apart, from which the search goes on",
    )
    delays: tuple[float, ...] = setting(
        (0.0, 0.025, 0.05, 0.1, 0.2),
        unit="record lengths",
        doc="times of the force in the record that are tried, the last one the largest",
        derived="usual pre-triggers; the line-to-line phase of a delay is 2 pi times it",
    )
    least_end: float = setting(
        1e-6, doc="least height of an exponential window at its end", derived="that of an analyser"
    )
    largest_end: float = setting(
        0.9, doc="largest height of an exponential window at its end", derived="a higher one shows in no line"
    )
    first_steps: tuple[float, float] = setting(
        (0.2, 0.02),
        doc="first steps of the logarithm of the window's decay and of the delay",
        derived="below half of the distance of the values tried",
    )
    parameter_tolerance: float = setting(
        0.005, doc="step of either at which the search ends", derived="0.5 % of the decay"
    )
    likelihood_tolerance: float = setting(
        1e-4, doc="gain of the mean log-likelihood at which it ends", derived="a tenth with all 1000 fits"
    )
    evaluations: int = setting(
        60, unit="likelihoods", doc="largest number of evaluations", derived="a second of computation"
    )


ERROR_CORRELATION = ErrorCorrelationSettings()

"""Settings of averaged spectra: quadrature of leakage, variance and random draws."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class QuadratureSettings(Settings):
    """Quadrature of stationary spectra over the band."""

    gauss_points: int = setting(
        10,
        unit="points",
        doc="Gauss points of a panel",
        derived="1e-8 of a spectrum on panels no longer than twice their distance from a pole",
    )
    derivative_points: int = setting(
        5,
        unit="points",
        doc="Gauss points of a panel where spectra are differentiated",
        derived="1e-3 of a spectrum at the worst line",
    )
    coarse_points: int = setting(
        2,
        unit="points",
        doc="points of a line of the unrefined grid for screening",
        derived="a squared line shape holds no finer detail",
    )
    near_lines: float = setting(
        64.0,
        unit="lines",
        doc="distance from a line up to which nodes of the unrefined grid count one by one",
        derived="a shape of 1/y^2, without a window, changes by (block_lines/y)^2/4 = 0.4 % over a block",
    )
    block_lines: int = setting(
        8, unit="lines", doc="lines of a block of nodes that counts as one", derived="as near_lines"
    )
    min_half_width: float = setting(
        1e-6,
        unit="lines",
        doc="narrowest half bandwidth that panels are refined to",
        derived="far below any resonance that a line shows",
    )


@dataclass(frozen=True)
class LeakageKernelSettings(Settings):
    """Interpolation of distant leakage."""

    near_lines: int = setting(
        4,
        unit="lines",
        doc="distance up to which nodes count one by one",
        derived="Bernstein ellipse: beyond, interpolation is exact to 1e-9",
    )
    n_points: int = setting(
        10,
        unit="points",
        doc="interpolation points of a line beyond that distance",
        derived="Bernstein ellipse: 16^-10, times some hundred for poles of sixth order",
    )
    derivative_points: int = setting(
        4,
        unit="points",
        doc="the same where spectra are differentiated",
        derived="16^-4, times some hundred: 1e-3 of what leaks from afar",
    )


@dataclass(frozen=True)
class RecordCorrelationSettings(Settings):
    """Correlation of successive records."""

    n_records: int = setting(
        4,
        unit="records",
        doc="records ahead for which the covariance is computed",
        derived="Gauss points resolve so many turns a line",
    )
    window_samples: int = setting(
        4096,
        unit="samples",
        doc="samples of a window for its autocorrelation",
        derived="exact for sums of cosines",
    )
    min_half_width: float = setting(
        1e-3,
        unit="lines",
        doc="narrowest half bandwidth of a mode",
        derived="keeps the sum of the geometric tail finite",
    )


@dataclass(frozen=True)
class SimulatedVarianceSettings(Settings):
    """Variance of spectra by simulated tests."""

    n_tests: int = setting(
        12,
        unit="tests",
        doc="simulated tests",
        derived="of four the scatter is known to a factor of two only",
    )
    n_stepped_tests: int = setting(
        4,
        unit="tests",
        doc="simulated tests where nonlinear forces are integrated in time",
        derived="computing time",
    )
    max_averages: int = setting(
        50, unit="averages", doc="averages of a simulated test", derived="computing time"
    )
    values_per_octave: int = setting(
        2,
        unit="1",
        doc="parameter values an octave that have factors of their own",
        tuned="test_simulated_variance.py passes with half and with twice the value",
    )
    significance_ratio: float = setting(
        1.75,
        unit="1",
        doc="variance over that of Gaussian records below which it is chance",
        derived="three standard errors of a variance from 4 tests and 5 complex lines: 1 + 3/sqrt(15)",
    )
    smoothing_lines: int = setting(
        5,
        unit="lines",
        doc="lines of a running mean of squares",
        tuned="test_simulated_variance.py passes with 3 to 20, not with 1",
    )


@dataclass(frozen=True)
class WishartSettings(Settings):
    """Draws of averaged spectra."""

    single_force_block: int = setting(
        2**14, unit="values", doc="spectral values drawn in one call, one force", derived="cache size"
    )
    multiple_force_block: int = setting(
        2**16,
        unit="values",
        doc="spectral values drawn in one call, several forces",
        derived="cache size against the cost of a call",
    )
    min_averages: int = setting(
        2,
        unit="averages",
        doc="averages from which the unmeasured part of the signal is drawn",
        derived="degrees of freedom beside the force and what it explains",
    )


@dataclass(frozen=True)
class NoiseBiasRemovalSettings(Settings):
    """Correction of FRFs for noise."""

    min_averages: int = setting(
        2,
        unit="averages",
        doc="averages up to which coherence carries no information",
        derived="coherence of one average is 1; its bias at two is of its own size",
    )


QUADRATURE = QuadratureSettings()
LEAKAGE_KERNEL = LeakageKernelSettings()
RECORD_CORRELATION = RecordCorrelationSettings()
SIMULATED_VARIANCE = SimulatedVarianceSettings()
WISHART = WishartSettings()
NOISE_BIAS = NoiseBiasRemovalSettings()

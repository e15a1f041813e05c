"""Settings of the correlation of modes and of frequency responses."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ModePairingSettings(Settings):
    """Modal assurance criteria and the pairing of modes."""

    min_mac: float = setting(
        0.3,
        doc="MAC below which modes do not pair",
        tuned="simulated tests of the suite: unlike shapes at about ten DoFs hardly reach it by chance",
    )
    pole_order: int = setting(
        10,
        doc="highest power of the pole in a pole-weighted vector",
        derived="Phillips, Allemang and Brown (2011): 5 to 10",
    )
    max_model_modes: int = setting(
        100, unit="modes", doc="modes of a model computed by default", derived="time of an eigensolution"
    )


PAIRING = ModePairingSettings()


@dataclass(frozen=True)
class ResponseCorrelationSettings(Settings):
    """Frequency domain assurance criterion (FDAC) and its ridge."""

    max_frequency_scale: float = setting(
        1.5,
        doc="largest frequency scale, or its inverse, among the candidates for the ridge",
        derived="a stiffness wrong by a factor of 2.25",
    )
    min_common_lines: float = setting(
        0.5,
        doc="fraction of the lines that a candidate scale must leave in both bands",
        derived="a mean over half of the lines or more",
    )
    plotted_lines: int = setting(
        200, unit="lines", doc="lines of an FDAC along either axis", derived="resolution of a plot"
    )
    max_plotted_values: int = setting(
        4_000_000, unit="values", doc="values of an FDAC over all its inputs", derived="memory: 32 MB"
    )
    ridge_lines: int = setting(
        600,
        unit="lines",
        doc="lines of the logarithmic grid on which the ridge is searched",
        derived="steps below 1 % of frequency over two decades, refined by a parabola",
    )
    ridge_start: float = setting(
        0.02, doc="lowest frequency of that grid over the highest", derived="about two decades"
    )


RESPONSES = ResponseCorrelationSettings()


@dataclass(frozen=True)
class SuspicionSettings(Settings):
    """Suspicion of causes by the residuals of a prediction."""

    numbers_per_mode: int = setting(
        3,
        unit="numbers",
        doc="independent numbers of a mode's residual",
        derived="its frequency, damping and amplitude",
    )
    excluded_errors: float = setting(
        2.0,
        unit="standard errors",
        doc="distance beyond which a correlation is excluded",
        derived="2 sigma: a false suspect costs a few predictions",
    )
    unlikely: float = setting(
        0.1,
        doc="suspicion of a cause that the residuals neither show nor exclude",
        derived="above the least suspicion of a search, below that of any cause that residuals show",
    )


SUSPICION = SuspicionSettings()

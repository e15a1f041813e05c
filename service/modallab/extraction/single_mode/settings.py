"""Settings of the single-mode methods and of their standard errors."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class LineChoiceSettings(Settings):
    """Lines of a single-mode fit where the user leaves them open."""

    lines: int = setting(
        8,
        unit="lines",
        doc="Lines about a resonance in data without leakage.",
        derived="weighted fits depend on few lines, and near lines contain least of the other modes",
    )
    leaked_lines: int = setting(
        12,
        unit="lines",
        doc="Lines about a resonance in data with leakage.",
        derived="leakage distorts the lines far from resonance least",
    )
    half_power_widths: float = setting(
        3.0,
        unit="half-power bandwidths",
        doc="Least width of a window.",
        derived="a narrower window shows an arc instead of a circle",
    )
    h1_left_out: int = setting(
        4,
        unit="lines",
        doc="Lines nearest to resonance that are not used in leaked H1 estimates.",
        tuned="simulated tests, modes of one line or less: better than with them at any number of averages",
    )


@dataclass(frozen=True)
class SingleModeFitSettings(Settings):
    """Iterations over the modes of all FRFs."""

    iterations: int = setting(
        3,
        doc="Fits with the other modes subtracted.",
        derived="the remainder of a neighbour after one subtraction is of second order; later ones converge",
    )
    leaked_iterations: int = setting(
        16,
        doc="The same where leakage is corrected by the mode itself.",
        derived="the correction needs the mode that it corrects; H1 converges slowest",
    )
    leakage_error: float = setting(
        0.1,
        doc="Relative error of a leaked line at the peak, proportional to the squared response elsewhere.",
        tuned="simulated modes down to 0.1 lines wide: the fit then depends on the flanks and converges",
    )
    late_step: float = setting(
        0.5,
        doc="Part of the change of the correction that is taken in the second half of the iterations.",
        derived="modes much narrower than a line oscillate about the solution with full steps",
    )
    smallest_eigenvalue: float = setting(
        1e-12,
        unit="(rad/s)^2",
        doc="Floor of squared angular frequencies in a division.",
        derived="below that of any mode and of any line above 0 Hz",
    )


@dataclass(frozen=True)
class ViscousFitSettings(Settings):
    """Fit of a viscously damped mode by methods for one pole."""

    mirror_iterations: int = setting(
        4,
        doc="Fits between which the mirror pole is subtracted.",
        derived="each wins two digits at a damping ratio of 5 %",
    )
    largest_damping_ratio: float = setting(
        0.99, doc="Upper bound of the damping ratio.", derived="a mode above it has no resonance"
    )


@dataclass(frozen=True)
class ScreeningSettings(Settings):
    """Acceptance of single-FRF fits."""

    largest_error: float = setting(
        0.5,
        unit="bandwidths or lines",
        doc="Standard error of a frequency up to which a fit is a mode.",
        derived="a mode with a larger error may be noise",
    )
    largest_mean_error: float = setting(
        0.1,
        unit="bandwidths or lines",
        doc="Standard error of the mean frequency over the FRFs up to which a mode is accepted.",
        tuned="chosen by judgement; test_screening.py passes with half and with twice the value",
    )
    outlier_deviations: float = setting(
        5.0,
        unit="robust standard deviations",
        doc="Distance from the median beyond which a fit is an outlier.",
        derived="one fit in a million lies so far out by chance",
    )
    smallest_scatter: float = setting(
        0.02,
        unit="bandwidths, or loss factors",
        doc="Scatter below which fits agree.",
        tuned="chosen by judgement; test_screening.py passes with half and with twice the value",
    )
    imprecision: float = setting(
        10.0,
        unit="median standard errors",
        doc="Standard error above which a fit is too imprecise.",
        derived="a plain mean would inherit it",
    )
    mad_to_deviation: float = setting(
        1.4826,
        doc="Standard deviation over median absolute deviation.",
        derived="normal distribution",
    )


@dataclass(frozen=True)
class FeedbackSettings(Settings):
    """Feedback of a mode on the lines that it corrects for leakage."""

    step: float = setting(
        0.03,
        unit="half bandwidths",
        doc="Step of the difference quotient.",
        derived="its truncation and rounding errors both stay far below it",
    )
    smallest_relative_step: float = setting(
        1e-6,
        unit="eigenvalues",
        doc="Least half bandwidth that a step is a part of.",
        derived="keeps the quotient of an undamped mode above rounding",
    )
    smallest_singular_value: float = setting(
        0.02,
        doc="Least singular value of 1 - J that is inverted.",
        derived="a mode that the lines hardly determine gets a large but finite error",
    )
    unsettled_strength: float = setting(
        5.0,
        doc="Gain at which fits depend on their starting values, as at the centre of a line.",
        tuned="test_leaked_fits.py passes with 2.5, not with 1 or 10",
    )


@dataclass(frozen=True)
class InfluenceSettings(Settings):
    """Influence function of a single-mode fit."""

    step: float = setting(
        1e-6,
        unit="largest lines",
        doc="Step of the difference quotient.",
        derived="its truncation and rounding errors are both far below it",
    )


@dataclass(frozen=True)
class ResidualBiasSettings(Settings):
    """Bias by contributions from outside the frequency range."""

    minimum_modes: int = setting(
        3,
        unit="modes",
        doc="Least number of modes.",
        derived="two terms fit any remainder at two modes exactly",
    )


@dataclass(frozen=True)
class LinearFitSettings(Settings):
    """Levy's equation with renewed weights."""

    weight_iterations: int = setting(
        4, doc="Solutions with renewed weights.", derived="each wins two digits or more"
    )


@dataclass(frozen=True)
class CircleFitSettings(Settings):
    """Circle fit."""

    gauss_newton_steps: int = setting(
        4,
        doc="Steps on the distances from the circle.",
        derived="quadratic convergence from an algebraic start",
    )
    largest_half_tangent: float = setting(
        1e8, doc="Upper bound of tan(theta/2).", derived="a line opposite to resonance, to rounding"
    )
    plot_points: int = setting(
        181, unit="points", doc="Points of a drawn circle.", derived="one every 2 degrees"
    )


@dataclass(frozen=True)
class DobsonSettings(Settings):
    """Dobson's method."""

    weight_iterations: int = setting(
        3, doc="Fits with renewed weights.", derived="the weights converge to three digits in two"
    )


LINE_CHOICE = LineChoiceSettings()
SINGLE_MODE_FIT = SingleModeFitSettings()
VISCOUS_FIT = ViscousFitSettings()
SCREENING = ScreeningSettings()
FEEDBACK = FeedbackSettings()
INFLUENCE = InfluenceSettings()
RESIDUAL_BIAS = ResidualBiasSettings()
LINEAR_FIT = LinearFitSettings()
CIRCLE_FIT = CircleFitSettings()
DOBSON = DobsonSettings()

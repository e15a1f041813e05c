"""Settings of the averages over FRFs, of their checks and of the flags on modes."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

THREE_SIGMA = "3 sigma: one of 370 by chance"


@dataclass(frozen=True)
class NodeSettings(Settings):
    """Modal constants that do not differ from zero."""

    standard_errors: float = setting(
        3.0, unit="standard errors", doc="Size up to which a modal constant may be zero.", derived=THREE_SIGMA
    )
    relative_size: float = setting(
        0.02,
        unit="largest constants",
        doc="Size up to which contributions of other modes may explain a modal constant.",
        tuned="test_combine.py, test_extract.py and test_references.py pass with 0.002 to 0.16",
    )


@dataclass(frozen=True)
class MeanSettings(Settings):
    """Means over FRFs."""

    huber_threshold: float = setting(
        2.5,
        unit="standard errors",
        doc="Deviation beyond which the weight of a value falls as one over the deviation.",
        derived="one value in eighty lies so far off by chance",
    )
    iterations: int = setting(20, doc="Reweighted means.", derived="each iteration is a contraction")
    significance: float = setting(
        1e-3,
        doc="Probability of a chi-square below which values differ.",
        derived="false alarm of one test in a thousand",
    )


@dataclass(frozen=True)
class DampingModelSettings(Settings):
    """Choice between structural and viscous damping from the phases of modal constants."""

    minimum_modes: int = setting(
        3,
        unit="modes",
        doc="Least number of modes.",
        derived="with fewer, a phase error of a transducer looks like that of a damping model",
    )
    rejection_errors: float = setting(
        5.0,
        unit="standard errors",
        doc="Least distance from the phase of the other model.",
        tuned="test_damping_model.py and test_viscous_modes.py pass with 1.25 to 10, not with 20",
    )
    agreement_errors: float = setting(
        3.0, unit="standard errors", doc="Largest distance from the phase of the model.", derived=THREE_SIGMA
    )
    agreement_fraction: float = setting(
        0.25,
        unit="viscous phases",
        doc="Largest distance from the phase of the model where standard errors are smaller.",
        tuned="test_damping_model.py and test_viscous_modes.py pass from a quarter to twice the value",
    )
    flagged_fraction: float = setting(
        1 / 3,
        unit="standard errors",
        doc="Difference of the frequency under the other model above which a flag is set.",
        derived="intervals that omit it still contain the value in 94 % instead of 95 % of cases",
    )


@dataclass(frozen=True)
class DrivePointSettings(Settings):
    """Checks of the modal constant of the drive point."""

    phase_errors: float = setting(
        3.0, unit="standard errors", doc="Phase that is significant.", derived=THREE_SIGMA
    )
    largest_phase: float = setting(
        20.0,
        unit="degrees",
        doc="Phase above which a flag is set.",
        derived="closely spaced modes of lightly damped structures stay below",
    )
    largest_scale_error: float = setting(
        0.2,
        doc="Relative standard error of a shape's scale above which a flag is set.",
        tuned="test_driving_point.py: with twice the value, a drive point at "
        "a node gives a scale; with half it passes",
    )


@dataclass(frozen=True)
class DuplicateModeSettings(Settings):
    """Modes of a global method that are one mode of inconsistent frequency."""

    unexplained_fraction: float = setting(
        0.1,
        doc="Part of the squared shifts of a mode that its cause may leave unexplained.",
        derived="a mode that leaves more may be two modes",
    )


@dataclass(frozen=True)
class InconsistencySettings(Settings):
    """Frequencies that differ between FRFs."""

    neglected_error: float = setting(
        0.002,
        unit="bandwidths",
        doc="Error by other modes in single-mode fits of exact data.",
        tuned="chosen by judgement; test_frequency_inconsistency.py passes with "
        "half and with twice the value",
    )
    cause_errors: float = setting(
        5.0, unit="standard errors", doc="Significance of a cause.", derived="one of 1.7 million by chance"
    )
    explained_fraction: float = setting(
        0.5, doc="Least part of the chi-square that a cause explains.", derived="more than what remains"
    )


@dataclass(frozen=True)
class MisfitSettings(Settings):
    """Lines that one mode does not explain."""

    largest_misfit: float = setting(
        0.1,
        unit="modal responses",
        doc="Root mean square of the remainder above which a flag is set.",
        derived="noise of 5 % leaves half of it, two modes within a bandwidth leave more",
    )


@dataclass(frozen=True)
class OutOfBandSettings(Settings):
    """Residuals outside the frequency bands."""

    undamped_limit: float = setting(
        0.5,
        unit="squared pole frequencies",
        doc="Squared frequency above which the term of an undamped pole is constant.",
        derived="the pole bends the lines below and has no resonance",
    )


@dataclass(frozen=True)
class ReferenceShapeSettings(Settings):
    """Shapes common to the modal constants of several references."""

    smallest_collinearity: float = setting(
        0.9,
        doc="Modal phase collinearity below which a shape is flagged as complex.",
        derived="random error of a few per cent leaves more",
    )
    iterations: int = setting(
        20, doc="Alternating least squares.", derived="noise of some per cent converges in a few"
    )
    inconsistency: float = setting(
        0.05,
        doc="Relative difference of references above which a flag is set.",
        derived="neighbouring modes in single-mode fits leave less",
    )
    inconsistency_errors: float = setting(
        3.0, unit="standard errors", doc="Difference of references that is significant.", derived=THREE_SIGMA
    )
    least_relative_error: float = setting(
        1e-6,
        doc="Relative error of the drive points' products below which they count equally.",
        derived="far below measured errors, far above rounding",
    )


@dataclass(frozen=True)
class ResynthesisSettings(Settings):
    """Comparison of synthesised with measured FRFs."""

    modal_error: float = setting(
        0.01,
        doc="Relative error of the modes in the weights of residuals.",
        derived="residuals must not compensate for errors of modes at resonance",
    )
    largest_misfit: float = setting(
        0.1,
        doc="Relative misfit of an FRF above which a note is given.",
        derived="random error and leakage of ordinary tests leave less",
    )
    misfit_errors: float = setting(
        3.0, unit="random errors", doc="Misfit that is significant.", derived=THREE_SIGMA
    )


@dataclass(frozen=True)
class SharedNoiseSettings(Settings):
    """Correlation of the errors of different FRFs."""

    minimum_pairs: int = setting(
        20,
        unit="pairs of lines",
        doc="Least number of pairs.",
        derived="fewer do not determine a correlation",
    )
    noted_fraction: float = setting(
        0.05, doc="Correlation above which a note is given.", derived="a smaller one is hardly significant"
    )


NODES = NodeSettings()
MEANS = MeanSettings()
DAMPING_MODEL = DampingModelSettings()
DRIVE_POINT = DrivePointSettings()
DUPLICATE_MODES = DuplicateModeSettings()
INCONSISTENCY = InconsistencySettings()
MISFIT = MisfitSettings()
OUT_OF_BAND = OutOfBandSettings()
REFERENCE_SHAPES = ReferenceShapeSettings()
RESYNTHESIS = ResynthesisSettings()
SHARED_NOISE = SharedNoiseSettings()

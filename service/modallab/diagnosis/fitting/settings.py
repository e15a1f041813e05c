"""Settings of fits and of the covariance of fitted parameters."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

TESTS = "simulated tests of the suite"


@dataclass(frozen=True)
class FitSettings(Settings):
    """Least-squares fits of the parameters of effects."""

    coarse_tolerance: float = setting(
        1e-2,
        unit="squared standard errors",
        doc="predicted gain at which a coarse fit, or a fit far from the data, ends",
        derived="a tenth of a standard error",
    )
    excess_share: float = setting(
        1e-3,
        doc="predicted gain at which a fit that leaves more than noise ends, over what it leaves",
        derived="far below what tells one effect from another; where only noise is left it is zero",
    )
    tolerance: float = setting(
        1e-4,
        unit="squared standard errors",
        doc="predicted gain at which a fit near the data ends",
        derived="a hundredth of a standard error",
    )
    excess_share_without_effects: float = setting(
        1e-4,
        doc="the same as `excess_share` of a fit of nuisance parameters alone near the data",
        derived="what an effect is missing in need not be known as well as what is left beside it",
    )
    nuisance_tolerance: float = setting(
        1e-3,
        unit="squared standard deviations",
        doc="predicted gain, for each nuisance parameter, at which a fit ends",
        derived="a thirtieth of a standard deviation; a hundred of them change chi-square by 0.1",
    )
    max_evaluations: int = setting(
        12,
        unit="evaluations",
        doc="evaluations of a fit, and as many again where the residuals are nearly noise",
        tuned=TESTS,
    )
    max_continuations: int = setting(
        3,
        doc="times as many evaluations of a fit near the data, until it converges",
        tuned="a spring on a student's cantilever: 1,200 squares above its minimum after the first ones",
    )
    continuation_ratio: float = setting(
        0.03,
        doc="share of the squares below which steps that were cut off go on",
        tuned="a mass on a fine bar: squares of 1e5 fell to 3.4 in twelve steps, to 1.0 in fourteen",
    )
    first_steps: int = setting(
        8,
        unit="evaluations",
        doc="evaluations without new derivatives after which a fit far above another is given up",
        tuned="a tolerated frame with 103 nuisance parameters: new derivatives cost as much as a hundred",
    )
    parameters_per_correction: int = setting(
        8,
        unit="parameters",
        doc="nuisance parameters for each correction of derivatives, far from the data, before their renewal",
        derived="corrections cost an evaluation each, a renewal one for each parameter",
    )
    parameters_per_renewal: int = setting(
        8,
        unit="parameters",
        doc="nuisance parameters for each renewal of the derivatives by effects alone, between two of all",
        derived="such a renewal costs two or three evaluations, one of all one for each parameter",
    )
    prediction_error: float = setting(
        0.5,
        unit="squared standard deviations",
        doc="loss by a step up to which two losses in a row may be errors of predictions at the minimum",
        derived="a step that could gain as much is 0.7 standard errors long",
    )
    max_corrections: int = setting(
        3,
        unit="corrections",
        doc="corrections of derivatives above which a fit near the data renews them",
        tuned="a tolerated test with 103 nuisance parameters: chi-square 20 above its minimum after 12",
    )
    poor_steps: int = setting(
        2,
        unit="evaluations",
        doc="poor steps in a row of a fit near the data before the derivatives are renewed",
        derived="a curved valley needs a shorter step, and a renewal costs as much as a hundred",
    )
    coarse_evaluations: int = setting(
        4, unit="evaluations", doc="evaluations of a coarse fit at each noise inflation", tuned=TESTS
    )
    unknown_damping_fits: int = setting(
        3,
        unit="fits",
        doc="fits of unknown loss factors before a search, each from where the one before ended",
        derived="they may be a factor 90 off, a fit is meant for starts near the solution",
    )
    approach_inflations: tuple[float, ...] = setting(
        (0.3, 0.03),
        doc="relative errors added to every random error, one stage of a fit far from the data each",
        derived="modes at other frequencies, then shifts by parts of a bandwidth",
    )
    approach_evaluations: int = setting(
        6, unit="evaluations", doc="evaluations of such a stage", derived="as many parameters are tolerated"
    )
    far_from_data: float = setting(
        100.0,
        doc="mean square of the residuals above which a fit is far from the data",
        derived="ten random errors: residuals near a shifted resonance are hundreds of them",
    )
    near_noise: float = setting(
        2.0, doc="mean square of the residuals below which a fit is worth finishing", tuned=TESTS
    )
    missing_effect_data: float = setting(
        50.0,
        unit="independent data",
        doc="independent data that the residual of a missing effect amounts to",
        derived="it is the residual of a few resonances, not of as many random numbers as lines",
    )
    noise_inflation_schedule: tuple[float, ...] = setting(
        (0.3, 0.1, 0.03, 0.003),
        doc="relative errors added to every random error, one stage of a coarse fit after the other",
        tuned=TESTS,
    )


@dataclass(frozen=True)
class CovarianceSettings(Settings):
    """Standard errors of fitted parameters."""

    bound_distance: float = setting(
        0.01,
        unit="standard errors",
        doc="distance from a bound within which a parameter lies on it",
        derived="tolerance of a fit: a hundredth of a standard error",
    )


FIT = FitSettings()
COVARIANCE = CovarianceSettings()

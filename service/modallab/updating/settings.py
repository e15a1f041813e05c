"""Settings of updating on modes: coefficients, pairing, iteration, prior, weights and identifiability."""

import math
from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class CoefficientSettings(Settings):
    """Default bounds of correction coefficients."""

    lower: float = setting(
        0.05,
        doc="least factor of a matrix or property",
        derived="a member that has nearly vanished: matrices stay positive definite",
    )
    upper: float = setting(
        10.0,
        doc="largest factor of a matrix or property",
        derived="one decade: a larger error is another model",
    )
    loss_factor_bounds: tuple[float, float] = setting(
        (-1.0, 2.0),
        doc="least and largest loss factor that may be added to that of a member",
        derived="iterates may pass below zero, and no member loses much more than it stores",
    )


COEFFICIENTS = CoefficientSettings()


@dataclass(frozen=True)
class PairingSettings(Settings):
    """Measured modes and the modes of the model that may pair with them."""

    frequency_range: float = setting(
        2.0,
        doc="highest frequency of a mode that may pair, over the highest measured one",
        derived="a factor of 4 in stiffness",
    )
    damped_frequency_range: float = setting(
        8.0,
        doc="highest frequency of the modes of a damped model, over the highest measured one",
        tuned="cantilever of 390 DoFs: coefficients off by 1e-4 with loss factors of 0.05, 0.004 with 0.3",
    )
    frequency_penalty: float = setting(
        1e-3,
        doc="modal assurance criterion that a frequency ratio of e counts for",
        derived="decides only between modes that the sensors show alike, as those of one symmetry",
    )
    repeated_frequency_gap: float = setting(
        1e-4,
        doc="relative distance below which frequencies are repeated",
        derived="below it shapes are any of one subspace within usual errors of shapes",
    )
    max_imaginary_share: float = setting(
        0.1,
        doc="share of a shape out of phase with the rest from which no real mode stands for it",
        derived="its real part then has a MAC of 1 - 0.1^2 = 0.99 with the shape",
    )


PAIRING = PairingSettings()


@dataclass(frozen=True)
class IterationSettings(Settings):
    """Iterations of inverse eigensensitivity."""

    divergence_factor: float = setting(
        10.0,
        doc="growth of the balanced difference since the start that counts as divergence",
        derived="one decade: the linear equations say nothing there",
    )
    rounding_difference: float = setting(
        1e-6,
        doc="balanced difference that eigenvalues of a good model scatter by",
        tuned="eigenvalues of the models of the suite",
    )
    rank_jump: float = setting(
        1e3,
        doc="ratio of consecutive singular values that ends the rank",
        tuned="bay and beam of the 1992 thesis: element stages have condition numbers of 340 to 400",
    )


ITERATION = IterationSettings()


@dataclass(frozen=True)
class LocationSettings(Settings):
    """Suspected macro elements."""

    noticeable_change: float = setting(
        0.02,
        doc="change of a coefficient that can be suspected where none exceeds the threshold",
        derived="twice the default tolerance of the location stage",
    )
    noticeable_loss_factor: float = setting(
        0.002,
        doc="the same for loss factors",
        derived="as much less as their default threshold is lower: 0.008 against 0.08",
    )
    damping_threshold: float = setting(
        0.008,
        doc="loss factor from which damping is suspected",
        tuned="bay of the 1992 thesis with loss factors of 0.05",
    )


LOCATION = LocationSettings()


@dataclass(frozen=True)
class OneStageSettings(Settings):
    """Path of an update in one stage, in logarithms of coefficients."""

    max_log_change: float = setting(
        math.log(2.0),
        doc="largest change of the logarithm of a coefficient in one step",
        derived="a coefficient at most doubles or halves",
    )
    step_reduction: float = setting(
        1 / 3,
        doc="factor of a step after which the model makes no sense",
        tuned="test_one_shot.py and test_correct.py pass with 1/6 to 2/3",
    )
    max_reductions: int = setting(
        6,
        unit="steps",
        doc="reductions of one step before the path has diverged",
        derived="3^-6 = 0.001 of a step",
    )
    initial_variance: float = setting(
        0.1,
        doc="variance of log coefficients from which prior variances are sought",
        derived="coefficients wrong by a third",
    )
    bound_range_deviations: float = setting(
        4.0,
        unit="standard deviations",
        doc="width of the bounds in standard deviations of the prior `range`",
        derived="bounds at 2 sigma",
    )


ONE_STAGE = OneStageSettings()


@dataclass(frozen=True)
class SparseBayesSettings(Settings):
    """Evidence maximisation of prior variances and block variances."""

    max_rounds: int = setting(
        100,
        unit="rounds",
        doc="alternating updates of prior and block variances",
        tuned="chosen by judgement: further rounds move a mean by less than its error",
    )
    tolerance: float = setting(
        1e-3,
        doc="relative change of all variances that ends the rounds",
        tuned="chosen by judgement; test_sparse_bayes.py passes with half and with twice the value",
    )
    min_determination: float = setting(
        1e-5,
        doc="determination by the data below which a coefficient's prior variance becomes zero",
        tuned="chosen by judgement; test_sparse_bayes.py passes with half and with twice the value",
    )
    revived_variance: float = setting(
        1e-6,
        doc="prior variance with which an eliminated coefficient starts at the next linearisation",
        tuned="chosen by judgement; test_sparse_bayes.py passes with half and with twice the value",
    )
    min_residual_freedom: float = setting(
        0.2,
        doc="least share of the rows of a block that count as degrees of freedom of its residual",
        tuned="chosen by judgement; test_sparse_bayes.py passes with half and with twice the value",
    )


SPARSE_BAYES = SparseBayesSettings()


@dataclass(frozen=True)
class WeightSettings(Settings):
    """Errors of measured eigenvalues and shapes."""

    min_relative_error: float = setting(
        1e-7,
        doc="least relative error of a row",
        tuned="scatter of eigenvalues of the models of the suite",
    )
    max_deviations: float = setting(
        3.0,
        unit="standard errors",
        doc="misfit of a mode, in its stated errors, from which the result names it",
        derived="3 sigma: one of 370 by chance",
    )
    max_unstated_misfit: float = setting(
        0.02,
        doc="relative misfit of an eigenvalue without stated error from which the result names its mode",
        derived="a frequency off by 1 %",
    )
    shape_error_ratio: float = setting(
        10.0,
        doc="relative error of shapes over that of eigenvalues where none is stated",
        derived="noise levels of the 1992 thesis: 5 % of shapes with 0.5 % of eigenvalues",
    )


WEIGHTS = WeightSettings()


@dataclass(frozen=True)
class SignificanceSettings(Settings):
    """Coefficients that are suspected after an update in one stage."""

    min_deviations: float = setting(
        3.0,
        unit="standard errors",
        doc="distance from the nominal value at which a coefficient is suspected",
        derived="3 sigma: one of 370 by chance",
    )


SIGNIFICANCE = SignificanceSettings()


@dataclass(frozen=True)
class IdentifiabilitySettings(Settings):
    """Null space, confidence intervals and varimax rotation of directions."""

    normal_quantile: float = setting(
        1.959964,
        unit="standard errors",
        doc="half width of a 95 % confidence interval",
        derived="0.975 quantile of the normal distribution",
    )
    null_share: float = setting(
        1e-6,
        doc="squared share of a coefficient in the null space that is more than rounding",
        derived="the square of a share of 0.1 %",
    )
    named_share: float = setting(
        0.25,
        doc="share of a direction, over its largest, from which a coefficient is named",
        tuned="tables of members of the bay",
    )
    max_rotations: int = setting(
        50,
        unit="rotations",
        doc="iterations of the varimax rotation",
        tuned="chosen by judgement; test_identifiability.py passes with half and with twice the value",
    )


IDENTIFIABILITY = IdentifiabilitySettings()


@dataclass(frozen=True)
class EnsembleSettings(Settings):
    """Ensemble of Markov chains that sample the posterior."""

    min_chains: int = setting(
        16,
        unit="chains",
        doc="least number of chains",
        tuned="test_sampling.py passes with 4 to 32",
    )
    chains_per_coefficient: float = setting(
        2.5,
        doc="chains over free coefficients",
        derived="more than 2, so that differences of chains span all directions",
    )
    burn_in_fraction: float = setting(
        0.25,
        doc="discarded steps over recorded ones",
        tuned="chosen by judgement: chains start from the linearised posterior",
    )
    differential_move_fraction: float = setting(
        0.8,
        doc="share of differential-evolution moves, the others being snooker moves",
        derived="documentation of emcee",
    )
    interval_tail: float = setting(
        0.025,
        doc="probability outside the interval on either side",
        derived="95 % intervals",
    )


ENSEMBLE = EnsembleSettings()

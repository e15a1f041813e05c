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
class LossSettings(Settings):
    """Robust cost of coarse predictions."""

    noise_inflations: tuple[float, ...] = setting(
        (0.0, 0.03, 0.3),
        doc="relative errors added to every random error, one ranking each",
        derived="from residuals of the size of noise to modes at other frequencies",
    )
    cauchy_scale: float = setting(
        9.0,
        unit="squared standard deviations",
        doc="scale of the Cauchy loss, above which a residual hardly adds to the cost",
        derived="3 sigma: such a line only shows that the prediction is wrong, not by how much",
    )
    product_length: int = setting(
        4,
        unit="residuals",
        doc="residuals whose logarithms are computed as one of their product",
        derived="the product does not overflow; a logarithm costs many multiplications",
    )


@dataclass(frozen=True)
class StartingValueSettings(Settings):
    """Values of an effect's parameters on a coarse grid."""

    ratios: tuple[float, ...] = setting(
        (0.1, 0.3, 0.6, 0.85, 0.98, 0.998, 1.002, 1.02, 1.2, 1.6, 3.0, 8.0),
        doc="values, over the neutral one, of a parameter whose neutral value is positive",
        tuned=TESTS,
    )
    grid_step: float = setting(0.25, unit="decades", doc="step of a logarithmic grid", tuned=TESTS)
    decades: float = setting(
        3.0, unit="decades", doc="range of a grid to either side of a typical value", tuned=TESTS
    )
    signed_decades: tuple[float, float] = setting(
        (-2.0, 1.0),
        unit="decades",
        doc="range of a grid, over the typical distance from the neutral value, of a signed parameter",
        tuned=TESTS,
    )
    max_minima: int = setting(
        3, unit="values", doc="local minima of an effect at a place that are fitted", tuned=TESTS
    )
    max_cost_ratio: float = setting(
        3.0, doc="cost of a local minimum over that of the best one up to which it is fitted", tuned=TESTS
    )
    min_share: float = setting(
        1e-3,
        doc="least amount, over the scaled one, of a parameter bounded at its neutral value",
        derived="an amount must differ from the neutral value",
    )


@dataclass(frozen=True)
class ShortlistSettings(Settings):
    """Suspects, places and values that are predicted."""

    max_places: int = setting(4, unit="places", doc="places of a kind for each noise inflation", tuned=TESTS)
    max_refined_places: int = setting(
        8,
        unit="places",
        doc="places of a kind whose amounts are refined, for each noise inflation",
        derived="twice those that are predicted",
    )
    refinements: tuple[tuple[float, int], ...] = setting(
        ((0.7, 8), (0.15, 5), (0.05, 5)),
        doc="logarithm of an amount over the best one, to either side, and the amounts tried in that range",
        derived="to the next value of the grid, then to the next of these",
    )
    sample_size: int = setting(
        1500, unit="FRF values", doc="values of all channels by which places are ranked", tuned=TESTS
    )
    max_linearised_places: int = setting(
        4,
        unit="places",
        doc="unmeasured places of a nonlinear force, by its equivalent linearisation, for each inflation",
        tuned=TESTS,
    )
    max_nonlinear_places: int = setting(
        2, unit="places", doc="places of a nonlinear force for each noise inflation", tuned=TESTS
    )
    nonlinear_sizes: int = setting(
        5, unit="values", doc="amounts, or a few more, by which places of it are ranked", tuned=TESTS
    )
    max_sizes: int = setting(
        20,
        unit="values",
        doc="values of an effect of channels or exciters up to which all are predicted",
        derived="beyond a scan for a resonance, whose values in closed form cost less than one prediction",
    )
    max_channels: int = setting(
        3, unit="channels", doc="channels of the largest gap for each noise inflation", tuned=TESTS
    )


@dataclass(frozen=True)
class ModificationScreenSettings(Settings):
    """Structural modifications at all places in closed form."""

    difference_step: float = setting(
        1e-6,
        doc="share of an exchange over which residuals are differentiated",
        derived="far above rounding and far below the width of any resonance",
    )


@dataclass(frozen=True)
class ScanSettings(Settings):
    """Candidates that coarse fits start from."""

    amount_shares: tuple[float, float] = setting(
        (0.4, 2.0), doc="range of a better amount over that of the grid", derived="the grid values beside it"
    )
    amount_trials: int = setting(
        8, unit="predictions", doc="amounts of that range that are tried", derived="steps of a quarter"
    )
    amount_steps: int = setting(
        5, unit="predictions", doc="predictions about the best of them", derived="to a tenth of a step"
    )
    max_starts: int = setting(
        5, unit="candidates", doc="best candidates for each noise inflation", tuned=TESTS
    )
    predictions_at_once: int = setting(
        32,
        unit="predictions",
        doc="values that are predicted before their costs are taken",
        derived="memory of as many residuals; values of all single channels of a roving test go together",
    )
    useful_cost: float = setting(
        0.99,
        doc="cost over that without the effect below which the best place of a kind is a candidate too",
        tuned=TESTS,
    )


@dataclass(frozen=True)
class RoundSettings(Settings):
    """One round of the search."""

    max_fits: int = setting(6, unit="fits", doc="candidates of a round that are fitted", tuned=TESTS)
    max_fits_of_kind: int = setting(3, unit="fits", doc="candidates of one kind among them", tuned=TESTS)
    min_fits: int = setting(
        3,
        unit="fits",
        doc="candidates that are fitted in any case",
        derived="a result shows the rivals of its explanation",
    )
    kinds_at_neighbours: int = setting(
        4,
        unit="kinds",
        doc="kinds of effects that are fitted at adjoining places too",
        tuned="members of a fine, lightly damped bar: with 2, one of seven is never fitted",
    )
    competitive_cost: float = setting(
        10.0,
        doc="cost over that of the best effect above which another is neither fitted nor followed",
        tuned=TESTS,
    )
    limiting_cost: float = setting(
        100.0,
        doc="chi-square after a few steps, over the best fit's, above which what that tends to is given up",
        tuned="a spring that a heavy oscillator below the band imitates: 50 times, and it explains the test",
    )
    budget_share: float = setting(
        0.5,
        doc="share of the remaining predictions that the fits of a round may take",
        derived="of a pair the second round costs as much as the first",
    )
    optional_cost: float = setting(
        2.0,
        doc="cost over that of the best fit above which no optional parameters are fitted",
        tuned="a foreign test of a viscous absorber: the damper of the right one closes a factor of 2.7",
    )
    declared_cost: float = setting(
        2.0,
        doc="chi-square over that of the best fit above which none is begun at the declared values too",
        tuned="a mass on a student's frame: 1.1 times that of the best wrong place, and 1/46 from there",
    )
    refitted_cost: float = setting(
        2.0,
        doc="chi-square over that of the best fit, up to which other tolerances repeat a fit in full",
        tuned="a rotational spring at the drive beside a bending stinger: given up after a few steps",
    )
    linear_share: float = setting(
        0.6, doc="share of a round's progress before nonlinear forces", tuned="CPU time of simulated tests"
    )
    declared_starts: int = setting(
        2,
        unit="fits",
        doc="fits in a row that a start at the declared values does not improve, after which none is tried",
        tuned="the mass of `declared_cost` is second; of a model a little wrong none of ten was improved",
    )
    hopeless_cost: float = setting(
        2.0,
        doc="cost of a coarse fit, over that of an explanation that leaves noise, above which none is fitted",
        tuned=TESTS,
    )
    same_cost: float = setting(
        0.01,
        doc="relative difference in cost within which two coarse fits of an effect end in the same minimum",
        derived="ends of coarse fits differ by less than a hundredth of the cost",
    )


@dataclass(frozen=True)
class ResonanceSettings(Settings):
    """Sizes of an effect on the exciter that are compared with the data at all lines."""

    largest_ratio: float = setting(
        1.35,
        doc="largest ratio of a size to that of the fit",
        derived="16 % of the frequency: coarse lines are no farther apart from the sixth of them on",
    )
    n_values: int = setting(
        61,
        unit="sizes",
        doc="sizes of the effect",
        derived="steps of 0.5 % of the frequency, a quarter of a bandwidth at a loss factor of 0.02",
    )


@dataclass(frozen=True)
class SingleLineSettings(Settings):
    """Effects that show in single lines."""

    least_excess: float = setting(
        6.0,
        unit="standard deviations",
        doc="excess of an incoherent spectrum at a line over all beside it from which an effect shows",
        derived="beyond chance among a thousand lines and a dozen channels (4.5)",
    )
    reach: int = setting(
        2, unit="lines", doc="lines on either side that show the effect too", derived="of windows in use"
    )
    lines_beside: int = setting(
        6, unit="lines", doc="further lines on either side", derived="a resonance is as wide as some of them"
    )
    few_channels: int = setting(
        2, unit="channels", doc="channels up to which each is taken for itself", tuned=TESTS
    )


@dataclass(frozen=True)
class NarrowingSettings(Settings):
    """Smaller effects in bursts, whose random errors are narrower."""

    ratio: float = setting(
        0.5,
        doc="size of an effect over that of the step before",
        derived="an octave: errors are known to that",
    )
    max_steps: int = setting(
        8, unit="steps", doc="largest number of steps", derived="two decades, as the grid of sizes is wide"
    )


@dataclass(frozen=True)
class SearchSettings(Settings):
    """Forward selection of effects."""

    max_branches: int = setting(
        3, unit="kinds", doc="first effects, of different kinds, that a second one is sought for", tuned=TESTS
    )
    closing_ratio: float = setting(
        0.5,
        doc="excess of the gap after an effect over that before, above which no third effect is sought",
        tuned="blind trial: effects outside the catalogue",
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
LOSS = LossSettings()
STARTING_VALUES = StartingValueSettings()
SHORTLIST = ShortlistSettings()
SCREENING = ModificationScreenSettings()
SCAN = ScanSettings()
ROUND = RoundSettings()
RESONANCE = ResonanceSettings()
SINGLE_LINES = SingleLineSettings()
NARROWING = NarrowingSettings()
SEARCH = SearchSettings()
MULTIPLE_ELEMENTS = MultipleElementsSettings()

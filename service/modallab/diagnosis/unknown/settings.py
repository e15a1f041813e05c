"""Settings of the search for an unknown effect."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class UnknownSettings(Settings):
    """Solution for an unknown cause."""

    max_steps: int = setting(
        30, unit="steps", doc="Gauss-Newton steps of a fit line by line", derived="ends sooner"
    )
    ranking_steps: int = setting(
        4,
        unit="steps",
        doc="steps of the fits by which places are ranked",
        derived="the cause is exact at its place, and nuisance parameters are nearly linear",
    )
    fitted_places: int = setting(
        16, unit="places", doc="places of them that are fitted", derived="four times those refined"
    )
    tolerance: float = setting(
        0.1, doc="gain in chi-square, over its mean, below which a fit ends", derived="far below one datum"
    )
    step_shares: tuple[float, ...] = setting(
        (1.0, 0.5, 0.2, 0.05, 0.0), doc="shares of a step tried at every line", derived="from all to none"
    )
    degree: int = setting(3, doc="degree of the spline of a curve", derived="continuous curvature")
    lines_per_coefficient: int = setting(
        10,
        unit="lines",
        doc="lines for one coefficient of a curve",
        derived="noise of single lines averages out",
    )
    starts: int = setting(
        12,
        doc="starts of a shape parameter of a model",
        derived="a factor of two apart in a band of four decades",
    )
    starting_loss_factors: tuple[float, ...] = setting(
        (0.01, 0.1, 0.5), doc="starts of a loss factor", derived="light, ordinary and heavy damping"
    )
    denominator_steps: int = setting(
        10,
        doc="fits of two poles, each weighted by the denominator of the one before",
        derived="it converges",
    )
    longest_delay: float = setting(
        12.0, unit="rad", doc="phase of the longest delay tried at the highest line", derived="two turns"
    )
    shortest_delay: float = setting(
        0.05, unit="rad", doc="phase of the shortest delay tried at the highest line", derived="three degrees"
    )
    range_of_shapes: float = setting(
        3.0,
        doc="largest change of a shape parameter's logarithm from its start",
        derived="a factor of twenty; starts are closer",
    )
    model_error: float = setting(
        0.05,
        doc="relative error of a curve, beside the random one, by errors of the model",
        tuned="curves of tests with a slightly wrong model",
    )
    alike: float = setting(
        10.0, doc="difference in BIC up to which places cannot be distinguished", derived="as between effects"
    )
    max_alike: int = setting(
        8, doc="places that are listed as not distinguishable", derived="a list that is read"
    )
    refinements: int = setting(
        25,
        doc="linearisations about the nuisance parameters at the best places",
        derived="each gains a third of what is left, or more",
    )
    refinement_gain: float = setting(
        1.0,
        doc="change of chi-square, over its mean, from one linearisation to the next at which they end",
        derived="one datum; places differ by ten where they can be told apart",
    )
    remaining_gain: float = setting(
        10.0,
        doc="gain that is left at most at a place, over that of its last linearisation",
        derived="a geometric series of nine tenths",
    )
    refined_places: int = setting(
        4,
        unit="places",
        doc="best places that are solved at all lines",
        derived="coarse lines rank nearly as all do",
    )
    range_of_amounts: float = setting(
        20.0, doc="largest change of an amount from its start, over it", derived="far"
    )
    refined_models: int = setting(
        6, doc="nearest models that are fitted to the FRFs", derived="estimates rank nearly as fits do"
    )
    model_share: float = setting(
        0.01,
        doc="share of what a smooth curve closes that a model may leave",
        derived="a model a little wrong leaves more",
    )
    linear_step: float = setting(
        0.01,
        unit="standard deviations",
        doc="step of nuisance parameters below which they are linear",
        derived="small",
    )
    cost_of_steps: float = setting(
        0.5, doc="gap that an effect beside an unknown one has to close", derived="half of random error"
    )
    closed_share: float = setting(
        0.5, doc="share of the gap's excess that an unknown effect has to close", derived="most of it"
    )
    difference_step: float = setting(
        1e-4, doc="relative step of a parameter for its standard error", derived="far above rounding"
    )


UNKNOWN = UnknownSettings()

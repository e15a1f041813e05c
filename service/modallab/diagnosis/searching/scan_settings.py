"""Settings of the scan: costs, starting values, shortlist."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting
from modallab.diagnosis.searching.settings import TESTS


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


LOSS = LossSettings()
STARTING_VALUES = StartingValueSettings()
SHORTLIST = ShortlistSettings()
SCREENING = ModificationScreenSettings()
SCAN = ScanSettings()

"""Settings of predictions: coarse lines, held-out responses, budget, limitations of a measurement."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

TESTS = "simulated tests of the suite"


@dataclass(frozen=True)
class PredictionSettings(Settings):
    """Coarse predictions and their cost."""

    coarse_lines: int = setting(130, unit="lines", doc="lines of a coarse prediction, at least", tuned=TESTS)
    remaining_decay: float = setting(
        0.01,
        doc="share of a response left at the end of a blow's record, up to which derivatives leave it out",
        derived="derivatives of logarithms are 10 % off, at antiresonances: a fit takes a step more",
    )
    nonlinear_cost: int = setting(
        10,
        unit="predictions",
        doc="predictions that take as long as one with a nonlinear force under a continuous spectrum",
        tuned="CPU time of simulated tests",
    )
    stepping_cost: int = setting(
        30,
        unit="predictions",
        doc="predictions with a nonlinear force that take as long as stepping it through one test",
        tuned="CPU time of simulated tests",
    )


@dataclass(frozen=True)
class HoldOutSettings(Settings):
    """Choice of the held-out responses."""

    min_responses: int = setting(
        4, unit="FRFs", doc="FRFs below which lines are held out instead of FRFs", tuned=TESTS
    )
    outlier_gap: float = setting(
        3.0,
        doc="gap over the median gap of all responses from which a response is an outlier",
        tuned=TESTS,
    )
    max_fraction: float = setting(
        0.5, doc="largest share of the FRFs to hold out", derived="a fit needs the larger part of the data"
    )


@dataclass(frozen=True)
class BudgetSettings(Settings):
    """End of a search that nears no explanation."""

    predictions_per_test: int = setting(
        3_000,
        unit="predictions",
        doc="predictions of all lines, for each test, after which a search follows no further candidate",
        tuned="blind trial: a pair of effects mostly takes half as many, hopeless searches took ten minutes",
    )
    nuisance_parameters: float = setting(
        100.0,
        unit="parameters",
        doc="nuisance parameters with which a test has twice as many predictions",
        tuned="a foreign pair under 45 of them takes 1.4 times what a test has without any",
    )
    first_search: float = setting(
        0.4,
        doc="share of the predictions for a search that a second one under assumed tolerances may follow",
        derived="two searches take little longer than one",
    )


@dataclass(frozen=True)
class LimitationSettings(Settings):
    """Limitations of a measurement that a diagnosis states."""

    few_averages: int = setting(
        10,
        unit="averages",
        doc="averages below which the random errors themselves are called poorly known",
        derived="random errors are then known to a third or worse",
    )
    low_coherence: float = setting(0.3, doc="coherence below which an FRF is hardly known", tuned=TESTS)
    many_lines: float = setting(
        0.1, doc="share of the lines from which a limitation of lines is stated", tuned=TESTS
    )
    other_force: float = setting(
        0.1,
        doc="logarithm of measured over expected mean force from which a ratio of noise is called unclear",
        derived="below, a level of noise is uncertain by as much as the scatter of its estimate",
    )
    max_pairs: int = setting(
        3, unit="pairs", doc="pairs of points named that are not reciprocal", derived="legibility"
    )


PREDICTION = PredictionSettings()
HOLD_OUT = HoldOutSettings()
BUDGET = BudgetSettings()
LIMITATIONS = LimitationSettings()

"""Fits the parameters of some effects together on expected spectra, with errors and bounds.

In every fit what may differ a little is free as well, held by its prior; see `tolerances`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.fitting.covariance import ParameterErrors, standard_errors
from modallab.diagnosis.fitting.held_out_nuisances import fit_held_out_nuisances
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.least_squares import BoundedGaussNewton
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import Residual, error_ratio, inflation_weights, residual
from modallab.rig.effect import Effect

NEAR, THERE = 1e-2, 1e-4  # squared standard errors that a fit is off its goal by at most
WORTH = 50.0  # independent numbers that what is missing is worth
PATIENCE = 12  # evaluations, and as many again where little is left to explain
NEARLY = 2.0  # mean square of the residuals, below which a fit is worth ending
NOISE_INFLATION_SCHEDULE = (0.3, 0.1, 0.03, 0.003)  # widenings a fit passes on its way to none


@dataclass(frozen=True, eq=False)
class Fit:
    """Effects with fitted parameters, and what they leave."""

    effects: tuple[Effect, ...]
    residual: Residual
    chi_square: float  # over the fitted lines and channels, and of what is tolerated
    n_parameters: int  # of the effects; what is tolerated is free in every fit alike
    n_data: int
    correlation_length: float  # how many data one independent datum stands for
    spread: Callable[[], ParameterErrors]
    nuisance_position: FloatArray = field(default_factory=lambda: np.zeros(0))  # position, see `Nuisances`
    # The same to look further from: as far as the fit is not right, drawn back to what is declared.
    starting_position: FloatArray = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def _spread(self) -> ParameterErrors:
        return self.spread()

    @property
    def errors(self) -> tuple[dict[str, float], ...]:
        """Standard errors, beside `effects`: worked out when asked for, as most fits only lose."""
        return self._spread.effects

    @property
    def nuisance_errors(self) -> FloatArray:
        """(n,) standard errors, beside `nuisance_position`."""
        return self._spread.nuisance_position

    @property
    def bic(self) -> float:
        """Bayesian information criterion, times the correlation of the data; lower is better."""
        independent = max(self.n_data / self.correlation_length, 2)
        return self.chi_square + self.n_parameters * self.correlation_length * float(np.log(independent))


def coarse_fit(
    glimpses: CoarsePrediction, fixed: Sequence[Effect], effect: Effect, widening: float
) -> tuple[Effect, float]:
    """Return an effect brought near its best value on first looks, and the cost it has there.

    Least squares with every random error widened, step by step down to the random errors alone: far
    from its goal the objective has many valleys, widened it has one. The numbers of effects accepted
    before, and what is tolerated, take part in straight lines.

    Parameters
    ----------
    widening
        How blurred to begin.
    """
    panel, thin, free = ParameterVector([effect]), glimpses.observed, glimpses.nuisances
    n, also, here, prior = len(panel), free.derivatives, free.position, np.sqrt(free.precision)

    def looked(effects: Sequence[Effect]) -> FloatArray:
        return residual(thin, glimpses.predict([*fixed, *effects])).vector(thin.fitted)

    def vector(u: FloatArray) -> FloatArray:
        left = looked(panel.with_values(u[:n]))
        return left if not len(here) else np.concatenate([left + also @ (u[n:] - here), prior * u[n:]])

    def slopes(u: FloatArray, there: FloatArray) -> FloatArray:
        total = there[: len(also)] - also @ (u[n:] - here) if len(here) else there
        return _beside(panel.derivatives(u[:n], looked, total), also, prior)

    start = np.concatenate([panel.start, here])
    low, high = np.concatenate([panel.low, free.low]), np.concatenate([panel.high, free.high])
    if not len(start):
        left = vector(start)
        return effect, float(left @ left)

    def weights(widen: float) -> FloatArray | None:
        own = inflation_weights(thin, thin.fitted, widen) if widen else None
        return None if own is None else np.concatenate([own, np.ones(len(here))])

    stages = (*(w for w in NOISE_INFLATION_SCHEDULE if w <= widening), 0.0)
    how = np.concatenate([[knob.spec.absent is None for knob in panel.parameters], np.zeros(len(here), bool)])
    if how.any() and not how[:n].all():
        # How much before how: while the amount is wrong it draws the rest to where nothing tells it any more.
        amounts = BoundedGaussNewton(
            vector, slopes, start, (np.where(how, start, low), np.where(how, start, high))
        )
        amounts.minimise(evaluations=4, tolerance=NEAR, weights=weights(stages[0]))
        start = amounts.position
    descent = BoundedGaussNewton(vector, slopes, start, (low, high))
    for widen in stages:
        descent.minimise(evaluations=4, tolerance=NEAR, weights=weights(widen))
    return panel.with_values(descent.position[:n])[0], float(descent.vector @ descent.vector)


def _sides(panel: ParameterVector) -> tuple[tuple[FloatArray, float], tuple[FloatArray, float]]:
    return (panel.low, -NUISANCE.max_deviation), (panel.high, NUISANCE.max_deviation)


def _beside(own: FloatArray, also: FloatArray, prior: FloatArray) -> FloatArray:
    """Return the derivatives by an effect's numbers and by those beside it, the prior's rows below."""
    n, m = own.shape[1], len(prior)
    if not m:
        return own
    below = np.hstack([np.zeros((m, n)), np.diag(prior)])
    return np.vstack([np.hstack([own, also]), below])


def fit(predictor: Predictor, effects: Sequence[Effect], *, fixed: Sequence[Effect] = ()) -> Fit:
    """Return the effects with all their parameters fitted together, from starts near their goal.

    Bounded least squares on logarithmic ratios.

    Parameters
    ----------
    fixed
        Effects that act but are not fitted.
    """
    plain, predictor = predictor, predictor.with_intermittent_errors([*fixed, *effects])
    task = _Task(predictor, fixed, ParameterVector(effects))
    start = np.concatenate([task.panel.start, predictor.position[task.free]])
    if len(start):
        low, high = (np.concatenate([s, np.full(len(task.free), end)]) for s, end in _sides(task.panel))
        descent = BoundedGaussNewton(task.vector, task.derivatives, start, (low, high))
        descent.minimise(evaluations=PATIENCE, tolerance=NEAR)
        if float(descent.vector @ descent.vector) < NEARLY * len(descent.vector):
            descent.minimise(evaluations=PATIENCE, tolerance=THERE)
        start, slopes = descent.position, descent.jacobian[: len(descent.vector) - len(task.free)]
    else:
        task.vector(start)
        slopes = np.zeros((1, 0))
    left, final, position = task.seen[start.tobytes()], *task.at(start)
    best = left.vector(predictor.observed.fitted)
    chi_square = float(best @ best) + predictor.observed.correlation_length * float(position @ position)
    # Where the fit is not yet right the residuals' own size says more than the random error does.
    scale = predictor.observed.correlation_length * max(1.0, float(best @ best) / len(best))
    outlook = position.copy()
    # What a missing effect leaves is of a few resonances, not of as many random numbers as there are lines.
    few = scale + predictor.observed.correlation_length * max(0.0, float(best @ best) - len(best)) / WORTH
    outlook[task.free] += _drawn_back(slopes / np.sqrt(few), position[task.free])
    predictor = predictor.with_nuisances_at(position)
    if len(task.own):
        position = fit_held_out_nuisances(predictor, [*fixed, *final], left, task.own)
        predictor = predictor.with_nuisances_at(position)
        left = predictor.residual([*fixed, *final])
    spread = partial(standard_errors, predictor, tuple(fixed), tuple(final), left)
    if predictor.observed is not plain.observed:
        # As large as it is likely: wider errors have to pay for what they forgive.
        chi_square -= 2 * float(np.log(error_ratio(plain.observed, predictor.observed)).sum())
        left = plain.with_nuisances_at(position).residual([*fixed, *final])
    return Fit(
        tuple(final),
        left,
        chi_square,
        len(task.panel),
        len(best),
        plain.observed.correlation_length,
        spread,
        position,
        outlook,
    )


def _drawn_back(slopes: FloatArray, position: FloatArray) -> FloatArray:
    """Return the step from the best of the data to the best of data and prior of the last numbers."""
    if not len(position):
        return position
    held = np.zeros(slopes.shape[1])
    held[len(held) - len(position) :] = 1.0
    pull = np.zeros(len(held))
    pull[len(held) - len(position) :] = position
    size = np.sqrt((slopes**2).sum(axis=0) + held) + 1e-150  # squared still a number
    curvature = (slopes.T @ slopes + np.diag(held)) / np.outer(size, size)
    step: FloatArray = -np.linalg.pinv(curvature) @ (pull / size) / size
    return step[len(held) - len(position) :]


class _Task:
    """The residuals of a fit by the numbers of effects and, behind them, what is tolerated."""

    def __init__(self, predictor: Predictor, fixed: Sequence[Effect], panel: ParameterVector) -> None:
        self.predictor, self.fixed, self.panel = predictor, tuple(fixed), panel
        observed = predictor.observed
        # What belongs to a channel that is held out no fitted line tells: it is settled afterwards.
        self.free, self.own = predictor.nuisances.split(observed.outputs, observed.held_out)
        self.seen: dict[bytes, Residual] = {}
        self._known: dict[bytes, Predicted] = {}
        self._prior = np.full(len(self.free), np.sqrt(observed.correlation_length))

    def at(self, u: FloatArray) -> tuple[list[Effect], FloatArray]:
        """Return the effects, and all that is tolerated."""
        position = self.predictor.position.copy()
        position[self.free] = u[len(self.panel) :]
        return self.panel.with_values(u[: len(self.panel)]), position

    def vector(self, u: FloatArray) -> FloatArray:
        """Return the residuals at the fitted lines and channels, then those of the prior."""
        effects, position = self.at(u)
        predicted = self.predictor.with_nuisances_at(position).predict([*self.fixed, *effects])
        left = residual(self.predictor.observed, predicted)
        self.seen[u.tobytes()], self._known[u.tobytes()] = left, predicted
        data = left.vector(self.predictor.observed.fitted)
        return np.concatenate([data, self._prior * u[len(self.panel) :]])

    def derivatives(self, u: FloatArray, _here: FloatArray) -> FloatArray:
        """Return the derivatives of residuals that were seen, (n_data, n)."""
        effects, position = self.at(u)
        observed = self.predictor.observed
        sketch = self.predictor.with_nuisances_at(position).linearisation_at([*self.fixed, *effects])

        def near(others: Sequence[Effect]) -> Predicted:
            return sketch([*self.fixed, *others])

        def vector(predicted: Predicted) -> FloatArray:
            return residual(observed, predicted).vector(observed.fitted)

        known = self._known[u.tobytes()]
        base = (
            known if known.excess_variance is None else near(effects)
        )  # where nothing leaks a sketch is all
        here = vector(base)
        own = self.panel.derivatives(u[: len(self.panel)], lambda others: vector(near(others)), here)
        numbers = self.predictor.nuisances
        also = numbers.derivatives(
            lambda more: sketch([*more, *self.fixed, *effects]), vector, base, observed, self.free
        )
        return _beside(own, also, self._prior)

"""Coarse fits: a candidate brought near its best value on coarse predictions."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.least_squares import BoundedGaussNewton, StepRules
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import inflation_weights, residual
from modallab.rig.effect import Effect


def coarse_fit(
    prediction: CoarsePrediction, fixed: Sequence[Effect], effect: Effect, noise_inflation: float
) -> tuple[Effect, float]:
    """Return an effect fitted on coarse predictions, and the cost of the fit.

    Least squares with every random error inflated, stage by stage down to the random errors alone: far
    from the solution the cost has many local minima, inflated it has one. The parameters of accepted
    effects and the nuisance parameters enter linearly.

    Parameters
    ----------
    fixed
        Accepted effects.
    effect
        The candidate with its starting values.
    noise_inflation
        Largest relative error added to every random error.
    """
    task = _CoarseTask(prediction, fixed, effect)
    n, start = len(task.parameters), task.start
    if not len(start):
        vector = task.vector(start)
        return effect, float(vector @ vector)
    stages = (*(w for w in FIT.noise_inflation_schedule if w <= noise_inflation), 0.0)
    rules = StepRules(FIT.coarse_evaluations, FIT.coarse_tolerance, FIT.excess_share)
    shapes = np.concatenate(
        [[p.spec.absent is None for p in task.parameters.parameters], np.zeros(len(start) - n, bool)]
    )
    if shapes.any() and not shapes[:n].all():
        # Amounts before shapes: a wrong amount draws the shape to where the data do not determine it.
        box = np.where(shapes, start, task.low), np.where(shapes, start, task.high)
        amounts = BoundedGaussNewton(task.vector, task.derivatives, start, box)
        amounts.minimise(rules, task.weights(stages[0]))
        start = amounts.position
    fit = BoundedGaussNewton(task.vector, task.derivatives, start, (task.low, task.high))
    for stage in stages:
        fit.minimise(rules, task.weights(stage))
    return task.parameters.with_values(fit.position[:n])[0], float(fit.vector @ fit.vector)


class _CoarseTask:
    """Residuals of a coarse fit by the parameters of one effect and, after them, linear nuisances."""

    def __init__(self, prediction: CoarsePrediction, fixed: Sequence[Effect], effect: Effect) -> None:
        self.parameters = ParameterVector([effect])
        self._prediction, self._fixed = prediction, fixed
        nuisances = prediction.nuisances
        self._slopes, self._position = nuisances.derivatives, nuisances.position
        self._prior = np.sqrt(nuisances.precision)
        self.start = np.concatenate([self.parameters.start, nuisances.position])
        self.low = np.concatenate([self.parameters.low, nuisances.low])
        self.high = np.concatenate([self.parameters.high, nuisances.high])

    def _residuals(self, effects: Sequence[Effect]) -> FloatArray:
        observed = self._prediction.observed
        predicted = self._prediction.predict([*self._fixed, *effects])
        return residual(observed, predicted).vector(observed.fitted)

    def vector(self, u: FloatArray) -> FloatArray:
        """Return the residuals (n_data,) at a position, then those of the prior."""
        n = len(self.parameters)
        residuals = self._residuals(self.parameters.with_values(u[:n]))
        if not len(self._position):
            return residuals
        return np.concatenate([residuals + self._slopes @ (u[n:] - self._position), self._prior * u[n:]])

    def derivatives(self, u: FloatArray, vector: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n) of the residuals."""
        n = len(self.parameters)
        base = vector
        if len(self._position):
            base = vector[: len(self._slopes)] - self._slopes @ (u[n:] - self._position)
        return with_prior_rows(
            self.parameters.derivatives(u[:n], self._residuals, base), self._slopes, self._prior
        )

    def weights(self, noise_inflation: float) -> FloatArray | None:
        """Return the weights (n_data,) of the residuals; None if all are 1."""
        if not noise_inflation:
            return None
        observed = self._prediction.observed
        weights = inflation_weights(observed, observed.fitted, noise_inflation)
        return np.concatenate([weights, np.ones(len(self._position))])


def with_prior_rows(derivatives: FloatArray, nuisances: FloatArray, prior: FloatArray) -> FloatArray:
    """Return derivatives by parameters and nuisance parameters, with the rows of the prior below.

    Parameters
    ----------
    derivatives
        (n_data, n) by the parameters.
    nuisances
        (n_data, m) by the nuisance parameters.
    prior
        (m,) derivatives of the residuals of the prior.
    """
    n, m = derivatives.shape[1], len(prior)
    if not m:
        return derivatives
    prior_rows = np.hstack([np.zeros((m, n)), np.diag(prior)])
    return np.vstack([np.hstack([derivatives, nuisances]), prior_rows])

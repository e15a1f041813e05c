"""Minimisation of the residuals of a fit, from a start near the solution or far from it."""

from collections.abc import Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.diagnosis.fitting.coarse_fit import with_prior_rows
from modallab.diagnosis.fitting.covariance import deviating_predictions
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.least_squares import BoundedGaussNewton, StepRules
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import Residual, inflation_weights, residual
from modallab.rig.effect import Effect


class FitTask:
    """Residuals of a fit by the parameters of effects and, after them, nuisance parameters.

    Parameters
    ----------
    known
        Derivatives (n_data, m) by the nuisance parameters, of a fit of the same data without the effects.
    keep_derivatives
        Whether renewals take them too, as that fit is so near the data that derivatives hardly differ.
    """

    def __init__(
        self,
        predictor: Predictor,
        fixed: Sequence[Effect],
        parameters: ParameterVector,
        known: NDArray[np.float32] | None,
        *,
        keep_derivatives: bool = False,
    ) -> None:
        self.predictor, self.fixed, self.parameters = predictor, tuple(fixed), parameters
        self._known, self._keep_derivatives = known, keep_derivatives
        observed = predictor.observed
        # Parameters of held-out channels alone act on no fitted line: they are fitted afterwards.
        self.free, self.held_out = predictor.nuisances.split(observed.outputs, observed.held_out)
        self.residuals: dict[bytes, Residual] = {}
        self._prior = np.full(len(self.free), np.sqrt(observed.correlation_length))

    def at(self, u: FloatArray) -> tuple[list[Effect], FloatArray]:
        """Return the effects and the position of all nuisance parameters."""
        n, position = len(self.parameters), self.predictor.position.copy()
        position[self.free] = u[n:]
        return self.parameters.with_values(u[:n]), position

    def vector(self, u: FloatArray) -> FloatArray:
        """Return the residuals at the fitted lines and channels, then those of the prior."""
        effects, position = self.at(u)
        predicted = self.predictor.with_nuisances_at(position).predict([*self.fixed, *effects])
        fitted_residual = residual(self.predictor.observed, predicted)
        self.residuals[u.tobytes()] = fitted_residual
        data = fitted_residual.vector(self.predictor.observed.fitted)
        return np.concatenate([data, self._prior * u[len(self.parameters) :]])

    def derivatives(self, u: FloatArray, _vector: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n) of residuals at a position that was evaluated."""
        known = self._known
        if not self._keep_derivatives:
            self._known = None  # they serve once: where they mislead they are renewed
        near = _Linearisation(self, u)
        nuisances = near.by_nuisances() if known is None else known.astype(float)
        return with_prior_rows(near.by_parameters(), nuisances, self._prior)

    def derivatives_by_parameters(self, u: FloatArray, _vector: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, k) by the parameters of the effects alone."""
        by_parameters = _Linearisation(self, u).by_parameters()
        return np.vstack([by_parameters, np.zeros((len(self._prior), by_parameters.shape[1]))])


class _Linearisation:
    """Derivatives of the residuals of a fit at a position."""

    def __init__(self, task: FitTask, u: FloatArray) -> None:
        self._task, self._u = task, u
        effects, self._position = task.at(u)
        self._predictor = task.predictor.with_nuisances_at(self._position)
        self._acting = [*task.fixed, *effects]
        self._predict = self._predictor.linearisation_at(self._acting)
        self._base = self._predict(self._acting)  # as the others: what approximations leave cancels

    def _vector(self, predicted: Predicted) -> FloatArray:
        observed = self._task.predictor.observed
        return residual(observed, predicted).vector(observed.fitted)

    def by_parameters(self) -> FloatArray:
        """Return the derivatives (n_data, k) by the parameters of the effects."""
        parameters = self._task.parameters

        def vector(perturbed: Sequence[Effect]) -> FloatArray:
            return self._vector(self._predict([*self._task.fixed, *perturbed]))

        return parameters.derivatives(self._u[: len(parameters)], vector, self._vector(self._base))

    def by_nuisances(self) -> FloatArray:
        """Return the derivatives (n_data, m) by the free nuisance parameters."""
        deviating = deviating_predictions(self._predictor, self._acting, self._predict)
        return self._predictor.nuisances.derivatives(
            lambda deviations: deviating([*deviations, *self._acting]),
            self._vector,
            self._base,
            self._task.predictor.observed,
            self._position,
            self._task.free,
        )


def minimised(task: FitTask, max_chi_square: float, *, approach: bool) -> tuple[FloatArray, FloatArray]:
    """Return the position of the minimum, and the derivatives of the data's residuals there.

    Parameters
    ----------
    max_chi_square
        Sum of squares above which the position after a few steps is returned.
    approach
        Whether random errors are inflated first where the start is far from the data.
    """
    parameters, limits = task.parameters, task.predictor.nuisances.limits[task.free]
    start = np.concatenate([parameters.start, task.predictor.position[task.free]])
    if not len(start):
        task.vector(start)
        return start, np.zeros((1, 0))
    low = np.concatenate([parameters.low, -limits])
    high = np.concatenate([parameters.high, limits])
    minimum = BoundedGaussNewton(
        task.vector,
        task.derivatives,
        start,
        (low, high),
        differentiate_first=task.derivatives_by_parameters if len(parameters) else None,
        partial_renewals=len(task.free) // FIT.parameters_per_renewal,
    )
    tolerated = len(task.free) * FIT.nuisance_tolerance
    if minimum.cost > max_chi_square:
        attempt = copy(minimum)
        attempt.minimise(
            StepRules(
                evaluations=FIT.first_steps,
                tolerance=FIT.coarse_tolerance + tolerated,
                corrections=FIT.first_steps,
                renewals=False,
            )
        )
        if attempt.cost > max_chi_square:
            return attempt.position, attempt.jacobian[: len(attempt.vector) - len(task.free)]
    if approach or not len(parameters):
        _approach(minimum, task)
    near_noise = FIT.near_noise * len(minimum.vector)
    _minimise_far_from_noise(
        minimum,
        StepRules(
            evaluations=FIT.max_evaluations,
            tolerance=FIT.coarse_tolerance + tolerated,
            excess_share=FIT.excess_share,
            # Where an effect is fitted too, corrected derivatives may end steps before they reach the data.
            corrections=1 if len(parameters) else _corrections(task),
            goal=near_noise,
        ),
    )
    if minimum.cost < near_noise:
        if minimum.corrections > FIT.max_corrections:
            minimum.renew()
        for _ in range(FIT.max_continuations):
            converged = minimum.minimise(
                StepRules(
                    evaluations=FIT.max_evaluations,
                    tolerance=FIT.tolerance + tolerated,
                    excess_share=0.0 if len(parameters) else FIT.excess_share_without_effects,
                    prediction_error=FIT.prediction_error,
                    corrections=_corrections(task),
                    partial_renewals=False,
                    poor_steps=FIT.poor_steps,
                )
            )
            if converged:
                break
    return minimum.position, minimum.jacobian[: len(minimum.vector) - len(task.free)]


def _minimise_far_from_noise(minimum: BoundedGaussNewton, rules: StepRules) -> None:
    """Take steps down to the goal of the rules, in several runs while each gains nearly all there is."""
    for _ in range(FIT.max_continuations):
        before = minimum.cost
        converged = minimum.minimise(rules)
        if converged or minimum.cost < rules.goal or minimum.cost > FIT.continuation_ratio * before:
            return


def _approach(minimum: BoundedGaussNewton, task: FitTask) -> None:
    """Bring a fit far from the data nearer, with every random error inflated, stage by stage.

    Where tolerances shift resonances by more than their bandwidths the cost has many local minima; inflated
    it has one.
    """
    observed, n_data = task.predictor.observed, len(minimum.vector)
    for inflation in FIT.approach_inflations:
        if minimum.cost < FIT.far_from_data * n_data:
            return
        weights = inflation_weights(observed, observed.fitted, inflation)
        minimum.minimise(
            StepRules(
                evaluations=FIT.approach_evaluations,
                tolerance=FIT.coarse_tolerance + len(task.free) * FIT.nuisance_tolerance,
                excess_share=FIT.excess_share,
                corrections=_corrections(task),
            ),
            np.concatenate([weights, np.ones(len(task.free))]),
        )


def _corrections(task: FitTask) -> int:
    """Return the corrections of derivatives that cost as much as a part of their renewal."""
    return max(1, len(task.free) // FIT.parameters_per_correction)

"""Gauss-Newton path of an update in one stage, with a sparse Bayesian prior."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import DivergedError, UnderdeterminedError
from modallab.core.progress import Progress, silent
from modallab.updating.iteration import (
    Iteration,
    IterationPath,
    StopReason,
    bound_note,
    check_sensitivity,
)
from modallab.updating.log_coefficients import from_log_changes, log_changes, log_derivatives
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.settings import ITERATION, ONE_STAGE
from modallab.updating.solve import ParameterStep, balanced_step
from modallab.updating.sparse_bayes import Equations, Posterior, Prior, sparse_bayes
from modallab.updating.weights import Weights


@dataclass(frozen=True)
class OneStageRule:
    """Prior distribution, and when the path ends."""

    prior: Prior
    tolerance: float
    """Largest change of a log coefficient at convergence."""
    max_iterations: int
    jump: float
    """Ratio of consecutive singular values that ends the rank."""


@dataclass(frozen=True, eq=False)
class OneStagePath:
    """Iterations of an update in one stage, and the posterior of the coefficients at the end."""

    initial: ModelState
    """Model at nominal coefficients."""
    iterations: IterationPath
    posterior: Posterior
    """Of the changes from nominal, `log_coefficients.log_changes`."""
    weights: Weights


def correct(model: ModalResiduals, rule: OneStageRule, progress: Progress = silent) -> OneStagePath:
    """Return the path from nominal coefficients to convergence.

    Each step linearises the measured modes in the logarithms of the coefficients, takes the posterior mean
    and moves there, with no coefficient more than doubled or halved. Errors of the linearisation count as
    errors of the data: in early steps they keep the prior strong, and they vanish at convergence. A
    coefficient that would leave its bounds stays there, and the others follow conditionally.

    Raises
    ------
    UnderdeterminedError
        If no measured number depends on any coefficient.
    """
    weights = Weights.of(model.target)
    start = state = model.state(model.parameterisation.nominal)
    initial_distance, history = start.distance, list[Iteration]()
    parameterisation = model.parameterisation
    posterior = initial_posterior(parameterisation, weights.floors, rule.prior)
    stop_reason, explanation = StopReason.STILL_MOVING, str(StopReason.STILL_MOVING)
    for count in range(rule.max_iterations):
        rows, residual = weights.rows(model, state)
        check_sensitivity(rows)
        linear = Equations(rows, residual, weights.block, weights.floors)
        posterior = linearised_posterior(
            parameterisation, state.values, linear, rule.prior, posterior.prior_variances
        )
        target_changes = bounded_mean(parameterisation, posterior)
        try:
            next_state, is_full_step = _damped_step(model, state, target_changes, initial_distance)
        except DivergedError as error:
            stop_reason, explanation = StopReason.DIVERGED, f"{StopReason.DIVERGED}: {error}"
            break
        largest = float(np.abs(target_changes - log_changes(model.parameterisation, state.values)).max())
        history.append(_record(model, state, next_state, least_squares_step(rows, residual, rule.jump)))
        state = next_state
        progress((count + 1) / rule.max_iterations, f"iteration {count + 1}: largest change {largest:.2g}")
        if largest < rule.tolerance and is_full_step:
            stop_reason, explanation = StopReason.CONVERGED, str(StopReason.CONVERGED)
            break
    if stop_reason is not StopReason.DIVERGED:
        explanation += bound_note(parameterisation, state.values)
    return OneStagePath(
        start, IterationPath(tuple(history), state, stop_reason, explanation), posterior, weights
    )


def least_squares_step(rows: FloatArray, residual: FloatArray, jump: float) -> ParameterStep:
    """Return the least-squares step of weighted rows (n_rows, n_params), without prior."""
    return balanced_step(rows, residual, np.ones(len(residual)), jump=jump)


def initial_posterior(parameterisation: Parameterisation, floors: FloatArray, prior: Prior) -> Posterior:
    """Return the distribution of changes before the first step: the prior alone.

    Parameters
    ----------
    floors
        (n_blocks,) least standard deviation of the rows of each block.
    """
    n = len(parameterisation.macros)
    prior_variances = np.full(n, ONE_STAGE.initial_variance)
    if prior is Prior.RANGE:
        lower, upper = (log_changes(parameterisation, bound) for bound in parameterisation.bounds)
        prior_variances = ((upper - lower) / ONE_STAGE.bound_range_deviations) ** 2
    return Posterior(np.zeros(n), np.diag(prior_variances), prior_variances, floors**2)


def linearised_posterior(
    parameterisation: Parameterisation,
    values: FloatArray,
    linear: Equations,
    prior: Prior,
    prior_variances: FloatArray,
) -> Posterior:
    """Return the posterior of the changes from nominal, with data linearised at `values`.

    Parameters
    ----------
    values, prior_variances
        (n_params,) coefficients, and initial prior variances.
    linear
        Derivatives with respect to the coefficients, and residuals.
    """
    rows = linear.matrix * log_derivatives(parameterisation, values)
    residual = linear.values + rows @ log_changes(parameterisation, values)
    equations = Equations(rows, residual, linear.block, linear.floors)
    return sparse_bayes(equations, prior, prior_variances, linear.mean_squares)


def bounded_mean(parameterisation: Parameterisation, posterior: Posterior) -> FloatArray:
    """Return the conditional posterior mean (n_params,), coefficients outside their bounds fixed there."""
    lower, upper = (log_changes(parameterisation, bound) for bound in parameterisation.bounds)
    mean, at_bound = posterior.mean, np.zeros(len(posterior.mean), bool)
    while (is_outside := ~at_bound & ((mean < lower) | (mean > upper))).any():
        at_bound |= is_outside
        excess = np.clip(posterior.mean, lower, upper)[at_bound] - posterior.mean[at_bound]
        # least squares, as coefficients that are only determined together have a singular covariance
        multipliers = np.linalg.lstsq(posterior.covariance[np.ix_(at_bound, at_bound)], excess, rcond=None)[0]
        mean = posterior.mean + posterior.covariance[:, at_bound] @ multipliers
    return np.asarray(np.clip(mean, lower, upper))


def _damped_step(
    model: ModalResiduals, state: ModelState, target_changes: FloatArray, initial_distance: float
) -> tuple[ModelState, bool]:
    """Return the model after a damped step towards the target, and whether the step was a full one.

    Raises
    ------
    DivergedError
        If no fraction of the step gives a model that pairs with the measured modes.
    """
    current_changes = log_changes(model.parameterisation, state.values)
    largest = float(np.abs(target_changes - current_changes).max())
    fraction = min(1.0, ONE_STAGE.max_log_change / max(largest, ONE_STAGE.max_log_change))
    max_distance = ITERATION.divergence_factor * max(initial_distance, ITERATION.rounding_difference)
    explanation = "the model moved away from the measurement"
    for _ in range(ONE_STAGE.max_reductions):
        # a full step takes the target itself: its sum would differ by rounding
        step_changes = current_changes + fraction * (target_changes - current_changes)
        if fraction == 1.0:
            step_changes = target_changes
        try:
            next_state = model.state(from_log_changes(model.parameterisation, step_changes))
            if next_state.distance < max_distance:
                return next_state, fraction == 1.0
        except (UnderdeterminedError, np.linalg.LinAlgError) as error:
            explanation = str(error)
        fraction *= ONE_STAGE.step_reduction
    raise DivergedError(explanation)


def _record(
    model: ModalResiduals, previous_state: ModelState, next_state: ModelState, step: ParameterStep
) -> Iteration:
    return Iteration(
        "updating",
        model.parameterisation.macros,
        next_state.values - previous_state.values,
        step.rank,
        step.singular_values,
        step.condition_number,
        next_state.values,
        next_state.frequencies,
        next_state.mac,
    )

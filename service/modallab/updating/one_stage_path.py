"""All coefficients corrected at once, from as much prior knowledge as the data call for."""

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
    """What is held likely before, and when the path ends."""

    prior: Prior
    tolerance: float  # of the largest relative change of a coefficient
    max_iterations: int
    jump: float  # of singular values, where the rank ends


@dataclass(frozen=True, eq=False)
class OneStagePath:
    """How all coefficients went at once, and what was believed of them at the end."""

    initial: ModelState
    iterations: IterationPath
    posterior: Posterior  # of their changes, `relative.log_changes`
    weights: Weights


def correct(model: ModalResiduals, rule: OneStageRule, progress: Progress = silent) -> OneStagePath:
    """Return the path from no change to where no coefficient moves by the tolerance.

    At every step the measured modes are made linear in the logarithms of the coefficients, and the
    coefficients most likely after prior and data are walked to, no farther than to twice or half of
    each. Errors of the straight line count as errors of the data: early, they keep those out that do
    not need to move, and go away with the steps. A coefficient that would leave its bounds stays there
    and the others are found again.

    Raises
    ------
    UnderdeterminedError
        If no measured number moves with any coefficient.
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
    """Return the step that solves rows (n_rows, n_params), in their units already, without any prior."""
    return balanced_step(rows, residual, np.ones(len(residual)), jump=jump)


def initial_posterior(parameterisation: Parameterisation, floors: FloatArray, prior: Prior) -> Posterior:
    """Return what is held likely of changes before the first step.

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
    """Return what data made linear at `values`, and the prior, say of all changes from the start.

    Parameters
    ----------
    values, prior_variances
        (n_params,) where the coefficients are, and what the prior's variances are looked for from.
    linear
        Derivatives by the coefficients, and what the model misses.
    """
    rows = linear.matrix * log_derivatives(parameterisation, values)
    residual = linear.values + rows @ log_changes(parameterisation, values)
    equations = Equations(rows, residual, linear.block, linear.floors)
    return sparse_bayes(equations, prior, prior_variances, linear.mean_squares)


def bounded_mean(parameterisation: Parameterisation, posterior: Posterior) -> FloatArray:
    """Return the changes most likely within their bounds: those beyond stay there, the others given that."""
    lower, upper = (log_changes(parameterisation, bound) for bound in parameterisation.bounds)
    mean, at_bound = posterior.mean, np.zeros(len(posterior.mean), bool)
    while (is_outside := ~at_bound & ((mean < lower) | (mean > upper))).any():
        at_bound |= is_outside
        excess = np.clip(posterior.mean, lower, upper)[at_bound] - posterior.mean[at_bound]
        # least squares: coefficients that only show together have a singular covariance
        multipliers = np.linalg.lstsq(posterior.covariance[np.ix_(at_bound, at_bound)], excess, rcond=None)[0]
        mean = posterior.mean + posterior.covariance[:, at_bound] @ multipliers
    return np.asarray(np.clip(mean, lower, upper))


def _damped_step(
    model: ModalResiduals, state: ModelState, target_changes: FloatArray, initial_distance: float
) -> tuple[ModelState, bool]:
    """Return the model a step nearer to what is wanted, and whether it is there."""
    current_changes = log_changes(model.parameterisation, state.values)
    fraction = min(
        1.0,
        ONE_STAGE.max_log_change
        / max(float(np.abs(target_changes - current_changes).max()), ONE_STAGE.max_log_change),
    )
    explanation = "the model moved away from the measurement"
    for _ in range(ONE_STAGE.max_reductions):
        step_changes = (
            target_changes
            if fraction == 1.0
            else current_changes + fraction * (target_changes - current_changes)
        )
        try:
            next_state = model.state(from_log_changes(model.parameterisation, step_changes))
            if next_state.distance < ITERATION.divergence_factor * max(
                initial_distance, ITERATION.rounding_difference
            ):
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

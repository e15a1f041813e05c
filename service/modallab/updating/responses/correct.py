"""Path of an update on frequency responses: wavefield reconstruction, then logarithmic ratios."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.progress import Progress, part, silent
from modallab.updating.iteration import Iteration, StopReason, bound_note, check_sensitivity
from modallab.updating.log_coefficients import from_log_changes, log_changes
from modallab.updating.one_stage_path import (
    OneStageRule,
    bounded_mean,
    initial_posterior,
    least_squares_step,
    linearised_posterior,
)
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.rows import (
    Rows,
    log_ratios,
    log_rows,
    mean_square,
    model_error_share,
    reconstruction_rows,
)
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.settings import ONE_STAGE
from modallab.updating.sparse_bayes import Equations, Posterior


@dataclass(frozen=True, eq=False)
class ResponsePath:
    """Iterations of an update on responses, and the posterior of the coefficients at the end."""

    values: FloatArray
    """Coefficients (n_params,)."""
    history: tuple[Iteration, ...]
    stop_reason: StopReason
    explanation: str
    """Reason for the end, for readers."""
    posterior: Posterior
    """Of the changes from nominal, `log_coefficients.log_changes`."""
    linear: Equations
    """Linearised log ratios at the values, in units of their errors."""
    initial_mean_square: float
    """Mean square of log ratios over their random error, nominal coefficients."""
    final_mean_square: float
    """The same at the end."""


def correct(
    model: ResponseModel, coarse_model: ResponseModel, rule: OneStageRule, progress: Progress = silent
) -> ResponsePath:
    """Return the path from no change to where no coefficient moves by the tolerance.

    Log ratios have a local minimum for every way in which resonances of the model can meet measured ones.
    The path therefore begins with equations of a model with a stiffness error everywhere
    (`reconstruction_rows`), whose assumed size falls from step to step, and ends with log ratios alone.
    Where these miss the measurement, a second path with smaller steps follows; the better of both counts.

    Parameters
    ----------
    coarse_model
        The same model at fewer lines, for wavefield reconstruction.

    Raises
    ------
    UnderdeterminedError
        If no response depends on any coefficient.
    """
    best: ResponsePath | None = None
    paths = list(zip(RESPONSE_PATH.error_factors, RESPONSE_PATH.max_steps, strict=True))
    for i, (error_factor, max_steps) in enumerate(paths):
        path_progress = part(progress, i / len(paths), (i + 1) / len(paths))
        path = _ResponsePathSolver(model, rule, path_progress).run(coarse_model, error_factor, max_steps)
        best = path if best is None or path.final_mean_square < best.final_mean_square else best
        if best.final_mean_square < RESPONSE_PATH.explained_mean_square:
            break
    assert best is not None
    return best


class _ResponsePathSolver:
    """State of one path."""

    def __init__(self, model: ResponseModel, rule: OneStageRule, progress: Progress) -> None:
        self._model, self._rule, self._progress = model, rule, progress
        self._parameterisation = model.parameterisation
        self._values = self._parameterisation.nominal
        self._posterior = initial_posterior(self._parameterisation, np.ones(1), rule.prior)
        self._history: list[Iteration] = []

    def run(self, coarse_model: ResponseModel, error_factor: float, max_steps: int) -> ResponsePath:
        """Return the path with at most `max_steps` steps of wavefield reconstruction, then of log ratios."""
        initial_mean_square = self._mean_square(self._values)
        for _ in range(max_steps):
            model_error = error_factor * model_error_share(coarse_model, self._values)
            if model_error < RESPONSE_PATH.min_model_error:
                break
            rows = reconstruction_rows(coarse_model, self._values, model_error)
            coefficients = self._target_changes(rows, _equations(rows, RESPONSE_PATH.coarse_block_rows))
            self._record(rows, self._coefficients_after(coefficients, 1.0))
        stop_reason, explanation = self._iterate_log_ratios()
        rows = log_rows(self._model, self._values)
        return ResponsePath(
            self._values,
            tuple(self._history),
            stop_reason,
            explanation + bound_note(self._parameterisation, self._values),
            self._posterior,
            _equations(rows, RESPONSE_PATH.block_rows),
            initial_mean_square,
            self._mean_square(self._values),
        )

    def _iterate_log_ratios(self) -> tuple[StopReason, str]:
        """Iterate log ratios to convergence, each step shortened until the mean square grows little."""
        mean_square_error = self._mean_square(self._values)
        for _ in range(self._rule.max_iterations):
            rows = log_rows(self._model, self._values)
            target_changes = self._target_changes(rows, _equations(rows, RESPONSE_PATH.block_rows))
            fraction, current_changes = 1.0, log_changes(self._parameterisation, self._values)
            for _ in range(ONE_STAGE.max_reductions):
                coefficients = self._coefficients_after(target_changes, fraction)
                next_mean_square = self._mean_square(coefficients)
                if next_mean_square < max(
                    RESPONSE_PATH.max_growth * mean_square_error, RESPONSE_PATH.accepted_mean_square
                ):
                    break
                fraction *= ONE_STAGE.step_reduction
            else:
                return (
                    StopReason.DIVERGED,
                    f"{StopReason.DIVERGED}: the model moved away from the measurement",
                )
            mean_square_error = next_mean_square
            self._record(rows, coefficients)
            largest = float(np.abs(target_changes - current_changes).max())
            if largest < self._rule.tolerance and fraction == 1.0:
                return StopReason.CONVERGED, str(StopReason.CONVERGED)
        return StopReason.STILL_MOVING, str(StopReason.STILL_MOVING)

    def _target_changes(self, rows: Rows, linear: Equations) -> FloatArray:
        check_sensitivity(rows.matrix)
        prior_variances = self._posterior.prior_variances
        self._posterior = linearised_posterior(
            self._parameterisation, self._values, linear, self._rule.prior, prior_variances
        )
        return bounded_mean(self._parameterisation, self._posterior)

    def _coefficients_after(self, target_changes: FloatArray, fraction: float) -> FloatArray:
        """Return the coefficients after a fraction of the step, which at most doubles or halves them."""
        current_changes = log_changes(self._parameterisation, self._values)
        fraction = min(
            fraction,
            ONE_STAGE.max_log_change
            / max(float(np.abs(target_changes - current_changes).max()), ONE_STAGE.max_log_change),
        )
        return from_log_changes(
            self._parameterisation,
            target_changes
            if fraction == 1.0
            else current_changes + fraction * (target_changes - current_changes),
        )

    def _record(self, rows: Rows, coefficients: FloatArray) -> None:
        step = least_squares_step(rows.matrix, rows.residual, self._rule.jump)
        no_modes = np.zeros(0)
        self._history.append(
            Iteration(
                "updating",
                self._parameterisation.macros,
                coefficients - self._values,
                step.rank,
                step.singular_values,
                step.condition_number,
                coefficients,
                no_modes,
                no_modes,
            )
        )
        self._values = coefficients
        largest = self._history[-1].max_change
        count = len(self._history)
        self._progress(1 - 0.9**count, f"iteration {count}: largest change {largest:.2g}")

    def _mean_square(self, values: FloatArray) -> float:
        target = self._model.target
        return float(mean_square(log_ratios(target, self._model.receptance(values)), target))


def _equations(rows: Rows, numbers: int) -> Equations:
    block = rows.blocks(numbers)
    return Equations(rows.matrix, rows.residual, block, np.full(int(block.max()) + 1, 1.0))

"""Iterations of correction coefficients to convergence, with a record of every step."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.core.errors import DivergedError, UnderdeterminedError
from modallab.core.progress import Progress, silent
from modallab.core.reply import NanFloat, Vector
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.parameterisation import MacroElement, Parameterisation
from modallab.updating.settings import ITERATION
from modallab.updating.solve import ParameterStep, at_bounds, bounded_step


@dataclass(frozen=True, eq=False)
class Iteration:
    """One step of an update and the model after it."""

    stage: str
    """`location` or `updating`."""
    macros: tuple[MacroElement, ...]
    """(n_params,) macro element of each coefficient."""
    step: Vector
    """Change of each coefficient (n_params,)."""
    rank: int
    """Rank of the weighted sensitivity matrix."""
    singular_values: Vector
    """Of the weighted sensitivity matrix, in falling order."""
    condition_number: NanFloat
    """Largest over smallest singular value within the rank."""
    coefficients: Vector
    """Coefficients after the step (n_params,)."""
    frequencies: Vector
    """Hz, natural frequencies of the model (n_modes,)."""
    mac: Vector
    """Modal assurance criterion of each pair of modes (n_modes,)."""

    def __post_init__(self) -> None:
        for name in ("step", "singular_values", "coefficients", "frequencies", "mac"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (None,), name=name))

    @property
    def max_change(self) -> float:
        """Largest change of a coefficient."""
        return float(np.abs(self.step).max())


@dataclass(frozen=True)
class StopRule:
    """Convergence tolerance, step length and number of iterations of a stage."""

    tolerance: float
    """Largest change of a coefficient at convergence."""
    max_step: float
    """Largest change of a coefficient in one step."""
    max_iterations: int
    jump: float
    """Ratio of consecutive singular values that ends the rank."""


class StopReason(StrEnum):
    """Reasons for the end of an update or of a stage."""

    CONVERGED = "no coefficient moved any more"
    STILL_MOVING = "the coefficients still moved after the last iteration allowed"
    DIVERGED = "diverged"
    SOLVED = "solved at once, without iteration"
    LOCATED = "errors are located, nothing is corrected"
    NOT_LOCATED = "no member is suspected, nothing is corrected"
    UNCHANGED = "nothing is corrected, the model stays as it is"


@dataclass(frozen=True, eq=False)
class IterationPath:
    """Iterations of one stage."""

    history: tuple[Iteration, ...]
    final: ModelState
    stop_reason: StopReason
    explanation: str
    """Reason for the end, for readers."""

    @property
    def converged(self) -> bool:
        """True if the coefficients converged."""
        return self.stop_reason is StopReason.CONVERGED


def iterate(
    residuals: ModalResiduals, start: FloatArray, rule: StopRule, *, stage: str, progress: Progress = silent
) -> IterationPath:
    """Return the Gauss-Newton path from `start` (n_params,) to convergence.

    Modes are paired again at every step. A path that loses a measured mode, or whose balanced difference
    grows by `ITERATION.divergence_factor`, has diverged and ends at the last valid model.

    Raises
    ------
    UnderdeterminedError
        If a measured mode has no partner at the start, or no measured number depends on any coefficient.
    """
    state = residuals.state(start)
    initial_distance = state.distance
    history: list[Iteration] = []
    for count in range(rule.max_iterations):
        step = _linear_step(residuals, state, rule)
        try:
            state = _next_state(residuals, state, step, initial_distance)
        except DivergedError as error:
            return IterationPath(
                tuple(history), state, StopReason.DIVERGED, f"{StopReason.DIVERGED}: {error}"
            )
        history.append(
            Iteration(
                stage,
                residuals.parameterisation.macros,
                step.parameters,
                step.rank,
                step.singular_values,
                step.condition_number,
                state.values,
                state.frequencies,
                state.mac,
            )
        )
        largest = history[-1].max_change
        progress((count + 1) / rule.max_iterations, f"{stage} {count + 1}: largest change {largest:.2g}")
        if largest < rule.tolerance and step.fraction == 1.0:
            return _finished_path(residuals, history, state, StopReason.CONVERGED)
    return _finished_path(residuals, history, state, StopReason.STILL_MOVING)


def _finished_path(
    residuals: ModalResiduals, history: list[Iteration], state: ModelState, stop_reason: StopReason
) -> IterationPath:
    return IterationPath(
        tuple(history), state, stop_reason, stop_reason + bound_note(residuals.parameterisation, state.values)
    )


def _linear_step(residuals: ModalResiduals, state: ModelState, rule: StopRule) -> ParameterStep:
    sensitivity = residuals.sensitivity(state)
    check_sensitivity(sensitivity)
    return bounded_step(
        sensitivity,
        state.difference,
        state.size,
        state.values,
        residuals.parameterisation.bounds,
        max_step=rule.max_step,
        jump=rule.jump,
    )


def _next_state(
    residuals: ModalResiduals, state: ModelState, step: ParameterStep, initial_distance: float
) -> ModelState:
    try:
        coefficients = np.clip(state.values + step.parameters, *residuals.parameterisation.bounds)
        next_state = residuals.state(coefficients)
    except (UnderdeterminedError, np.linalg.LinAlgError) as error:
        raise DivergedError(str(error)) from error
    if not next_state.distance < ITERATION.divergence_factor * max(
        initial_distance, ITERATION.rounding_difference
    ):
        raise DivergedError("the model moved away from the measurement")
    return next_state


def check_sensitivity(rows: FloatArray) -> None:
    """Raise `UnderdeterminedError` if the sensitivity matrix (n_rows, n_params) is zero."""
    if not rows.any():
        raise UnderdeterminedError(
            "no measured number moves with any coefficient",
            field="macros",
            value=rows.shape[1],
            allowed="parts of members that move in the measured modes",
        )


def stated_end(
    explanation: str, parameterisation: Parameterisation, values: FloatArray, tolerance: float
) -> str:
    """Return the reason for the end of an update, led by the outcome where no coefficient is corrected.

    Parameters
    ----------
    explanation
        Reason for the end of the path.
    values
        (n_params,) coefficients at the end.
    tolerance
        Largest change of a coefficient at convergence.
    """
    if (np.abs(values - parameterisation.nominal) > tolerance).any():
        return explanation
    if explanation.startswith(StopReason.DIVERGED):
        return f"{explanation}; {StopReason.UNCHANGED}"
    return f"{StopReason.UNCHANGED}: {explanation}"


def bound_note(parameterisation: Parameterisation, values: FloatArray) -> str:
    """Return a note on how many coefficients (n_params,) are at a bound; empty if none is."""
    n_at_bound = int(np.logical_or(*at_bounds(values, parameterisation.bounds)).sum())
    return f"; {n_at_bound} of {len(values)} coefficients rest on a bound" if n_at_bound else ""

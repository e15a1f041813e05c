"""All coefficients corrected at once, from as much prior knowledge as the data call for."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import DivergedError, UnderdeterminedError
from modallab.core.progress import Progress, silent
from modallab.updating.iteration import (
    ASTRAY,
    ROUNDING,
    Ending,
    Iteration,
    IterationPath,
    check_sensitivity,
    resting,
)
from modallab.updating.log_coefficients import changed, changes, slopes
from modallab.updating.modal_residuals import ModalResiduals, State
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.solve import ParameterStep, balanced_step
from modallab.updating.sparse_bayes import Equations, Posterior, Prior, sparse_bayes
from modallab.updating.weights import Weights

DOUBLED = float(np.log(2.0))  # a coefficient doubles or halves in one step, at most
SHORTER, TRIES = 1 / 3, 6  # a step after which the model makes no sense is shortened so often
START = 0.1  # variance from which the widths are looked for: coefficients wrong by a third
BOUNDS_APART = 4.0  # standard deviations of a prior between the bounds of a coefficient


@dataclass(frozen=True)
class Rule:
    """What is held likely before, and when the path ends."""

    prior: Prior
    tolerance: float  # of the largest relative change of a coefficient
    max_iterations: int
    jump: float  # of singular values, where the rank ends


@dataclass(frozen=True, eq=False)
class OneStagePath:
    """How all coefficients went at once, and what was believed of them at the end."""

    before: State
    path: IterationPath
    belief: Posterior  # of their changes, `relative.changes`
    weights: Weights


def correct(fit: ModalResiduals, rule: Rule, progress: Progress = silent) -> OneStagePath:
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
    weights = Weights.of(fit.target)
    start = state = fit.state(fit.parameterisation.unchanged)
    begun, history = start.distance, list[Iteration]()
    may_move = fit.parameterisation
    belief = opened(may_move, weights.floors, rule.prior)
    ending, why = Ending.STILL_MOVING, str(Ending.STILL_MOVING)
    for count in range(rule.max_iterations):
        rows, missed = weights.rows(fit, state)
        check_sensitivity(rows)
        linear = Equations(rows, missed, weights.block, weights.floors)
        belief = believed(may_move, state.values, linear, rule.prior, belief.widths)
        wanted = within_bounds(may_move, belief)
        try:
            after, whole = _walked(fit, state, wanted, begun)
        except DivergedError as error:
            ending, why = Ending.DIVERGED, f"{Ending.DIVERGED}: {error}"
            break
        far = float(np.abs(wanted - changes(fit.parameterisation, state.values)).max())
        history.append(_record(fit, state, after, unweighted(rows, missed, rule.jump)))
        state = after
        progress((count + 1) / rule.max_iterations, f"iteration {count + 1}: largest change {far:.2g}")
        if far < rule.tolerance and whole:
            ending, why = Ending.CONVERGED, str(Ending.CONVERGED)
            break
    if ending is not Ending.DIVERGED:
        why += resting(may_move, state.values)
    return OneStagePath(start, IterationPath(tuple(history), state, ending, why), belief, weights)


def unweighted(rows: FloatArray, missed: FloatArray, jump: float) -> ParameterStep:
    """Return the step that solves rows (n_rows, n_params), in their units already, without any prior."""
    return balanced_step(rows, missed, np.ones(len(missed)), jump=jump)


def opened(parameterisation: Parameterisation, floors: FloatArray, prior: Prior) -> Posterior:
    """Return what is held likely of changes before the first step.

    Parameters
    ----------
    floors
        (n_blocks,) least standard deviation of the rows of each block.
    """
    n = len(parameterisation.macros)
    widths = np.full(n, START)
    if prior is Prior.RANGE:
        lower, upper = (changes(parameterisation, bound) for bound in parameterisation.bounds)
        widths = ((upper - lower) / BOUNDS_APART) ** 2
    return Posterior(np.zeros(n), np.diag(widths), widths, floors**2)


def believed(
    parameterisation: Parameterisation,
    values: FloatArray,
    linear: Equations,
    prior: Prior,
    widths: FloatArray,
) -> Posterior:
    """Return what data made linear at `values`, and the prior, say of all changes from the start.

    Parameters
    ----------
    values, widths
        (n_params,) where the coefficients are, and what the prior's variances are looked for from.
    linear
        Derivatives by the coefficients, and what the model misses.
    """
    rows = linear.matrix * slopes(parameterisation, values)
    wanted = linear.values + rows @ changes(parameterisation, values)
    equations = Equations(rows, wanted, linear.block, linear.floors)
    return sparse_bayes(equations, prior, widths, linear.sizes)


def within_bounds(parameterisation: Parameterisation, belief: Posterior) -> FloatArray:
    """Return the changes most likely within their bounds: those beyond stay there, the others given that."""
    lower, upper = (changes(parameterisation, bound) for bound in parameterisation.bounds)
    wanted, held = belief.mean, np.zeros(len(belief.mean), bool)
    while (out := ~held & ((wanted < lower) | (wanted > upper))).any():
        held |= out
        ends = np.clip(belief.mean, lower, upper)[held] - belief.mean[held]
        # least squares: coefficients that only show together have a singular covariance
        given = np.linalg.lstsq(belief.covariance[np.ix_(held, held)], ends, rcond=None)[0]
        wanted = belief.mean + belief.covariance[:, held] @ given
    return np.asarray(np.clip(wanted, lower, upper))


def _walked(fit: ModalResiduals, state: State, wanted: FloatArray, begun: float) -> tuple[State, bool]:
    """Return the model a step nearer to what is wanted, and whether it is there."""
    now = changes(fit.parameterisation, state.values)
    share = min(1.0, DOUBLED / max(float(np.abs(wanted - now).max()), DOUBLED))
    why = "the model moved away from the measurement"
    for _ in range(TRIES):
        to = wanted if share == 1.0 else now + share * (wanted - now)
        try:
            after = fit.state(changed(fit.parameterisation, to))
            if after.distance < ASTRAY * max(begun, ROUNDING):
                return after, share == 1.0
        except (UnderdeterminedError, np.linalg.LinAlgError) as error:
            why = str(error)
        share *= SHORTER
    raise DivergedError(why)


def _record(fit: ModalResiduals, before: State, after: State, solved: ParameterStep) -> Iteration:
    return Iteration(
        "updating",
        fit.parameterisation.macros,
        after.values - before.values,
        solved.rank,
        solved.singular_values,
        solved.condition_number,
        after.values,
        after.frequencies,
        after.mac,
    )

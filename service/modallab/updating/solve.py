"""Least-squares step of the coefficients by singular value decomposition, within bounds."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.updating.settings import ITERATION


@dataclass(frozen=True, eq=False)
class ParameterStep:
    """One step of the coefficients, with rank and conditioning of its equations."""

    parameters: FloatArray  # (n_params,)
    singular_values: FloatArray  # (min(n_rows, n_params),) of the balanced matrix, falling
    rank: int
    inverse: FloatArray  # (n_params, n_rows) pseudo-inverse of the balanced matrix
    fraction: float = 1.0  # of the full step, below 1 where bounds shorten it

    @property
    def condition_number(self) -> float:
        """Largest over smallest singular value within the rank; 1 at rank zero."""
        if self.rank == 0:
            return 1.0
        return float(self.singular_values[0] / self.singular_values[self.rank - 1])


def balanced_step(
    sensitivity: FloatArray, difference: FloatArray, size: FloatArray, *, jump: float = ITERATION.rank_jump
) -> ParameterStep:
    """Return the least-squares step dp of S dp = delta by SVD, with each row divided by its `size`.

    The rank ends where one singular value is `jump` times the next, or at rounding: directions beyond it are
    not determined by the measurement. All values before that are used: cutting off small ones of an element
    stage, of condition 340 to 400, converges to a wrong point.

    Parameters
    ----------
    sensitivity
        (n_rows, n_params).
    difference, size
        (n_rows,): lambda_r for an eigenvalue row, 1 for an eigenvector row, which brings the
        condition number down from 1e8 or more.
    jump
        Ratio of consecutive singular values that ends the rank.
    """
    u, values, vh = np.linalg.svd(sensitivity / size[:, None], full_matrices=False)
    floor = np.finfo(float).eps * max(sensitivity.shape) * (values[0] if len(values) else 0.0)
    rank_gaps = np.flatnonzero(values[:-1] > jump * values[1:])
    rank = min(int(rank_gaps[0]) + 1 if rank_gaps.size else len(values), int((values > floor).sum()))
    inverse = (vh[:rank].T / values[:rank]) @ u[:, :rank].T
    return ParameterStep(inverse @ (difference / size), values, rank, inverse)


def bounded_step(
    sensitivity: FloatArray,
    difference: FloatArray,
    size: FloatArray,
    values: FloatArray,
    bounds: tuple[FloatArray | float, FloatArray | float],
    *,
    max_step: float,
    jump: float = ITERATION.rank_jump,
) -> ParameterStep:
    """Return the step of S dp = delta with every parameter within its bounds and `max_step`.

    A parameter at a bound with a step outwards is fixed there, and the others are solved for again (active
    set). Then the whole step is shortened until the largest change is `max_step` and every parameter is
    within its bounds. Clipping single components instead would turn the step away from the solution, and can
    diverge.

    Parameters
    ----------
    values
        (n_params,) parameters.
    bounds
        Lower and upper bound, of each parameter (n_params,) or of all alike.
    """
    lower, upper = bounds
    free = np.ones(len(values), bool)
    while True:
        step = balanced_step(sensitivity * free, difference, size, jump=jump)
        correction = step.parameters * free  # a fixed one would move by rounding
        low, high = at_bounds(values, bounds)
        is_outward = (low & (correction < 0)) | (high & (correction > 0))
        is_leaving = free & is_outward
        if not is_leaving.any():
            break
        free &= ~is_leaving
    allowance = np.minimum(np.where(correction > 0, upper - values, values - lower), max_step)
    fraction = np.divide(
        allowance, np.abs(correction), out=np.ones_like(correction), where=correction != 0
    ).min(initial=1.0)
    return replace(step, parameters=correction * fraction, fraction=float(fraction))


def at_bounds(
    values: FloatArray, bounds: tuple[FloatArray | float, FloatArray | float]
) -> tuple[BoolArray, BoolArray]:
    """Return masks of parameters at their lower and at their upper bound, (n_params,) each."""
    lower, upper = bounds
    return values <= lower + COMPARISON_ROUNDING * np.abs(
        lower
    ), values >= upper - COMPARISON_ROUNDING * np.abs(upper)

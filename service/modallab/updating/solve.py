"""One correction of the parameters, and how well the measurement determines it."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.updating.settings import ITERATION


@dataclass(frozen=True, eq=False)
class ParameterStep:
    """One correction of the parameters, and how well determined it was."""

    parameters: FloatArray  # (n_params,)
    singular_values: FloatArray  # (min(n_rows, n_params),) of the balanced matrix, falling
    rank: int
    inverse: FloatArray  # (n_params, n_rows): maps balanced differences to parameters
    fraction: float = 1.0  # of the step that solves the equations, shortened to keep within bounds

    @property
    def condition_number(self) -> float:
        """Largest over smallest singular value that counts; 1 where nothing was solved for."""
        if self.rank == 0:
            return 1.0
        return float(self.singular_values[0] / self.singular_values[self.rank - 1])


def balanced_step(
    sensitivity: FloatArray, difference: FloatArray, size: FloatArray, *, jump: float = ITERATION.rank_jump
) -> ParameterStep:
    """Return the dp that solves S dp = delta by SVD, each row divided by its own `size` first.

    The rank ends where one singular value is `jump` times the next, or where rounding begins: what
    lies beyond, the measurement does not show. Every value before that is used: cutting off small
    ones of an element stage, of condition 340 to 400, settles on a wrong point.

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
    """Return the step that solves S dp = delta with no parameter leaving its bounds or going far.

    A parameter that sits on a bound and would leave it is held there and the others solved for
    again; then the whole step is shortened until the largest change is `max_step` and every
    parameter within its bounds. Clipping single components instead turns the step away from the
    solution, and can diverge.

    Parameters
    ----------
    values
        (n_params,) where the parameters are.
    bounds
        Lower and upper bound, of each parameter (n_params,) or of all alike.
    """
    lower, upper = bounds
    free = np.ones(len(values), bool)
    while True:
        step = balanced_step(sensitivity * free, difference, size, jump=jump)
        correction = step.parameters * free  # a held one would move by a rounding error
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
    """Return which parameters sit on their lower and which on their upper bound, (n_params,) each."""
    lower, upper = bounds
    return values <= lower + COMPARISON_ROUNDING * np.abs(
        lower
    ), values >= upper - COMPARISON_ROUNDING * np.abs(upper)

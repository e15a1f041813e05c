"""Linear least squares between bounds."""

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.diagnosis.optimisation.settings import LEAST_SQUARES


def bounded_least_squares(
    matrix: FloatArray, target: FloatArray, box: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Return x (n,) between bounds that minimises |matrix x - target|.

    By block principal pivoting: all parameters that leave their bounds, or want to return from them, change
    sides at once, which takes a few solutions where many bounds hold. Where that does not end, one at a time.
    Portugal, Judice and Vicente, Mathematics of Computation 63 (1994), 625; Stark and Parker, Computational
    Statistics 10 (1995), 129.

    Parameters
    ----------
    matrix
        (m, n).
    target
        (m,).
    box
        Lower and upper bounds (n,).
    """
    low, high = box
    at_low = at_high = np.zeros(len(low), bool)
    for _ in range(LEAST_SQUARES.pivots):
        x = _with_fixed(matrix, target, np.where(at_low, low, high), at_low | at_high)
        if x is None:
            break
        slope = matrix.T @ (matrix @ x - target)
        now_low = np.where(at_low, slope > 0, x < low)
        now_high = np.where(at_high, slope < 0, x > high)
        if (now_low == at_low).all() and (now_high == at_high).all():
            return x
        at_low, at_high = now_low, now_high
    return np.asarray(scipy.optimize.lsq_linear(matrix, target, box, method="bvls").x.clip(low, high))


def _with_fixed(
    matrix: FloatArray, target: FloatArray, bound: FloatArray, fixed: BoolArray
) -> FloatArray | None:
    """Return the least-squares solution (n,) with some parameters on a bound; None if it is not unique."""
    x = np.where(fixed, bound, 0.0)
    free = ~fixed
    if not free.any():
        return x
    if free.all() and not np.tril(matrix, -1).any():  # a decomposition takes fifty times as long
        q, triangle = np.eye(*matrix.shape), matrix[: len(free)]
    else:
        q, triangle = np.linalg.qr(matrix[:, free])
    diagonal = np.abs(np.diag(triangle))
    if len(diagonal) < free.sum() or diagonal.min() <= PRODUCT_ROUNDING * diagonal.max():
        return None
    x[free] = scipy.linalg.solve_triangular(triangle, q.T @ (target - matrix @ x))
    return x

"""Products and solutions of many small linear systems, one for every frequency line."""

import numpy as np

from modallab.core.arrays import ComplexArray


def product(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return a @ b; over two columns without a call for every line."""
    if a.shape[-1] != 2:
        return np.asarray(a @ b)
    return np.asarray(a[..., 0, None] * b[..., None, 0, :] + a[..., 1, None] * b[..., None, 1, :])


def solve_small(matrix: ComplexArray, loads: ComplexArray) -> ComplexArray:
    """Return the solutions of stacked linear systems; in closed form for up to three unknowns.

    By Cramer's rule: a solver call for every line takes twice as long.
    """
    n = matrix.shape[-1]
    if n == 1:
        return np.asarray(loads / matrix)
    if n > 3:
        return np.asarray(np.linalg.solve(matrix, loads))
    load = [loads[..., i, :] for i in range(n)]
    adjugate: tuple[tuple[ComplexArray, ...], ...]
    if n == 2:
        a, b, c, d = (matrix[..., i, j, None] for i in range(2) for j in range(2))
        adjugate, determinant = ((d, -b), (-c, a)), a * d - b * c
    else:
        a, b, c, d, e, f, g, h, i = (matrix[..., j, k, None] for j in range(3) for k in range(3))
        first = e * i - f * h, f * g - d * i, d * h - e * g
        adjugate = (
            (first[0], c * h - b * i, b * f - c * e),
            (first[1], a * i - c * g, c * d - a * f),
            (first[2], b * g - a * h, a * e - b * d),
        )
        determinant = a * first[0] + b * first[1] + c * first[2]
    rows = [
        sum(factor * part for factor, part in zip(row, load, strict=True)) / determinant for row in adjugate
    ]
    return np.asarray(np.stack(rows, axis=-2))

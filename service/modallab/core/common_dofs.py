"""Common degrees of freedom of several sets, whatever their signs."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof


def common_points(*sides: Sequence[Dof]) -> tuple[Dof, ...]:
    """Return the DoFs common to all sides, sorted, in their positive sense."""
    first, *remaining = [{dof.point for dof in side} for side in sides]
    return tuple(sorted(first.intersection(*remaining)))


def rows_at(dofs: Sequence[Dof], points: Sequence[Dof]) -> tuple[IntArray, FloatArray]:
    """Return the rows of `points` among `dofs`, and the signs that bring these rows to the positive sense.

    A DoF that occurs twice is found at its first place.

    Parameters
    ----------
    dofs
        (n,), each in either sense.
    points
        (k,), each one of `dofs`.

    Returns
    -------
    (k,) rows and (k,) signs, 1 or -1.
    """
    row = {dof.point: i for i, dof in reversed(list(enumerate(dofs)))}
    rows = [row[point.point] for point in points]
    signs = np.array([dofs[i].sign for i in rows], float)
    return np.array(rows, dtype=np.int64), signs

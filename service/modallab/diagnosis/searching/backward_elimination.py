"""The fewest numbers that explain as much: columns dropped, or taken together, as long as BIC gains."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.searching.acceptance import CONVINCING

ROUNDING = 1e-10  # added to unit curvatures: of columns that say the same any one can go

Columns = list[tuple[int, ...]]
Together = Callable[[Sequence[int], Sequence[int]], bool]


@dataclass(frozen=True)
class Group:
    """Columns that share one number."""

    columns: tuple[int, ...]
    value: float


def backward_elimination(slopes: FloatArray, target: FloatArray, together: Together) -> list[Group]:
    """Return the groups of columns, one number each, that explain a target as well as all columns do.

    Backward elimination: whatever costs least goes, as long as BIC does not speak strongly against it.

    Parameters
    ----------
    slopes, target
        (n, n_columns) and (n,), in standard deviations: target = slopes @ numbers + noise.
    together
        Whether two groups may have one number.
    """
    squares = _Squares(slopes, target)
    groups: Columns = [(i,) for i in range(slopes.shape[1])]
    scale = max(1.0, squares.left(groups) / len(target))
    bit = scale * float(np.log(len(target)))
    groups = _without_needless(squares, groups, bit + CONVINCING * scale)
    while merged := _merged(squares, groups, together):
        loss, fewer = min(merged)
        if loss > bit:
            break
        groups = fewer
    groups = _without_needless(squares, groups, bit + CONVINCING * scale)
    values = squares.best(groups)
    return [Group(columns, float(value)) for columns, value in zip(groups, values, strict=True)]


def _without_needless(squares: "_Squares", groups: Columns, worth: float) -> Columns:
    """Return the groups without those whose loss adds less to the sum of squares than they are worth."""
    while groups:
        losses = squares.losses(groups)
        least = int(losses.argmin())
        if losses[least] > worth:
            break
        groups = groups[:least] + groups[least + 1 :]
    return groups


def _merged(squares: "_Squares", groups: Columns, together: Together) -> list[tuple[float, Columns]]:
    """Return what is left of the groups after two became one, each with what the sum of squares gains."""
    here, found = squares.left(groups), []
    for i, one in enumerate(groups):
        for j, other in enumerate(groups[:i]):
            if together(one, other):
                rest = [own for k, own in enumerate(groups) if k not in (i, j)]
                fewer = [*rest, tuple(sorted((*one, *other)))]
                found.append((squares.left(fewer) - here, fewer))
    return found


class _Squares:
    """The least squares of every choice of groups, from the normal equations of all columns."""

    def __init__(self, slopes: FloatArray, target: FloatArray) -> None:
        self._curvature, self._pull = slopes.T @ slopes, slopes.T @ target
        self._whole = float(target @ target)

    def _solved(self, groups: Columns) -> tuple[FloatArray, FloatArray]:
        """Return the number of each group, and the covariance of the numbers."""
        sums = np.zeros((len(self._pull), len(groups)))
        for i, columns in enumerate(groups):
            sums[list(columns), i] = 1.0
        curvature = sums.T @ self._curvature @ sums
        size = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        inverse = np.linalg.inv(curvature / np.outer(size, size) + ROUNDING * np.eye(len(size)))
        covariance = inverse / np.outer(size, size)
        return covariance @ (sums.T @ self._pull), covariance

    def best(self, groups: Columns) -> FloatArray:
        """Return the number of each group."""
        return self._solved(groups)[0]

    def losses(self, groups: Columns) -> FloatArray:
        """Return by how much more is left without each of the groups."""
        values, covariance = self._solved(groups)
        return np.asarray(values**2 / np.maximum(np.diag(covariance), 1e-300))

    def left(self, groups: Columns) -> float:
        """Return the sum of squares that groups leave."""
        pull = np.array([self._pull[list(columns)].sum() for columns in groups])
        return self._whole - float(self.best(groups) @ pull)

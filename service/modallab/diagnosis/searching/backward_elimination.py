"""Backward elimination of columns of a linear model, by elimination and by merging, as long as BIC gains."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import CURVATURE_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.searching.settings import ACCEPTANCE

ColumnGroups = list[tuple[int, ...]]
CanMerge = Callable[[Sequence[int], Sequence[int]], bool]


@dataclass(frozen=True)
class Group:
    """Columns that share one coefficient."""

    columns: tuple[int, ...]
    """Indices of the columns."""
    value: float
    """Their coefficient."""


def backward_elimination(slopes: FloatArray, target: FloatArray, can_merge: CanMerge) -> list[Group]:
    """Return the groups of columns, one coefficient each, that explain a target as well as all columns do.

    Backward elimination removes the column whose removal raises the loss least, until the Bayesian
    information criterion (BIC) is strongly against a removal.

    Parameters
    ----------
    slopes
        (n, n_columns), in standard deviations: target = slopes @ coefficients + noise.
    target
        (n,), in standard deviations.
    can_merge
        Whether two groups may share one coefficient.
    """
    model = _NormalEquations(slopes, target)
    groups: ColumnGroups = [(i,) for i in range(slopes.shape[1])]
    scale = max(1.0, model.residual_square(groups) / len(target))
    penalty = scale * float(np.log(len(target)))
    strong = penalty + ACCEPTANCE.very_strong_bic * scale
    groups = _eliminated(model, groups, strong)
    while merged := _merged(model, groups, can_merge):
        loss, fewer = min(merged)
        if loss > penalty:
            break
        groups = fewer
    groups = _eliminated(model, groups, strong)
    values = model.coefficients(groups)
    return [Group(columns, float(value)) for columns, value in zip(groups, values, strict=True)]


def _eliminated(model: "_NormalEquations", groups: ColumnGroups, max_loss: float) -> ColumnGroups:
    """Return the groups without those whose elimination adds at most `max_loss` to the residual square."""
    while groups:
        losses = model.losses(groups)
        least = int(losses.argmin())
        if losses[least] > max_loss:
            break
        groups = groups[:least] + groups[least + 1 :]
    return groups


def _merged(
    model: "_NormalEquations", groups: ColumnGroups, can_merge: CanMerge
) -> list[tuple[float, ColumnGroups]]:
    """Return the groups after each possible merger of two, with the increase of the residual square."""
    square, merged = model.residual_square(groups), []
    for i, group in enumerate(groups):
        for j, partner in enumerate(groups[:i]):
            if can_merge(group, partner):
                unchanged = [columns for k, columns in enumerate(groups) if k not in (i, j)]
                fewer = [*unchanged, tuple(sorted((*group, *partner)))]
                merged.append((model.residual_square(fewer) - square, fewer))
    return merged


class _NormalEquations:
    """Least squares of every choice of groups, from the normal equations of all columns."""

    def __init__(self, slopes: FloatArray, target: FloatArray) -> None:
        self._curvature, self._gradient = slopes.T @ slopes, slopes.T @ target
        self._target_square = float(target @ target)

    def _solution(self, groups: ColumnGroups) -> tuple[FloatArray, FloatArray]:
        """Return the coefficient of each group, and the covariance of the coefficients."""
        sums = np.zeros((len(self._gradient), len(groups)))
        for i, columns in enumerate(groups):
            sums[list(columns), i] = 1.0
        curvature = sums.T @ self._curvature @ sums
        size = np.sqrt(np.maximum(np.diag(curvature), SAFE_DIVISOR))
        # Ridge at rounding: of linearly dependent columns any one can go.
        inverse = np.linalg.inv(curvature / np.outer(size, size) + CURVATURE_ROUNDING * np.eye(len(size)))
        covariance = inverse / np.outer(size, size)
        return covariance @ (sums.T @ self._gradient), covariance

    def coefficients(self, groups: ColumnGroups) -> FloatArray:
        """Return the coefficient of each group, (n_groups,)."""
        return self._solution(groups)[0]

    def losses(self, groups: ColumnGroups) -> FloatArray:
        """Return the increase of the residual square without each of the groups, (n_groups,)."""
        values, covariance = self._solution(groups)
        return np.asarray(values**2 / np.maximum(np.diag(covariance), SAFE_DIVISOR))

    def residual_square(self, groups: ColumnGroups) -> float:
        """Return the residual sum of squares of groups."""
        gradient = np.array([self._gradient[list(columns)].sum() for columns in groups])
        return self._target_square - float(self.coefficients(groups) @ gradient)

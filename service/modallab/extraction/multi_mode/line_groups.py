"""Groups of adjacent lines whose weights differ by a factor common to all FRFs."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING, SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_settings import PROJECTION


@dataclass(frozen=True, eq=False)
class LineGroups:
    """Weights as products of a factor of the line and a level of its group in each FRF.

    Weighted products of columns are then summed once for a group, not once for each FRF.
    """

    group: IntArray
    """(n_lines,) index of the group of each line, ascending."""
    profile: FloatArray
    """(n_lines,) factor of each line, not negative."""
    level: FloatArray
    """(n_groups, n_frf) weight of the group's lines over their factor."""

    @property
    def worthwhile(self) -> bool:
        """Whether groups are so few that sums by groups take less time than sums by FRFs."""
        return len(self.level) * PROJECTION.least_group <= len(self.group)

    @property
    def weight(self) -> FloatArray:
        """(n_lines, n_frf)."""
        return np.asarray(self.profile[:, None] * self.level[self.group])


def proportional_groups(weight: FloatArray) -> LineGroups:
    """Return the groups of lines with exactly proportional weights.

    Parameters
    ----------
    weight
        (n_lines, n_frf), not negative.
    """
    profile = weight.sum(axis=1)
    level = weight / np.where(profile > 0, profile, 1.0)[:, None]
    step = np.abs(np.diff(level, axis=0)) > COMPARISON_ROUNDING * np.maximum(level[1:], level[:-1])
    first = _first_lines(np.asarray(step.any(axis=1)))
    return LineGroups(np.cumsum(first) - 1, profile, level[first])


def similar_groups(weight: FloatArray) -> LineGroups:
    """Return groups of few lines, with the mean error variance of each FRF over the factors of the lines.

    The factor of a line is the geometric mean of its weights. Lines that an FRF leaves out are in groups of
    their own.

    Parameters
    ----------
    weight
        (n_lines, n_frf), not negative.
    """
    used = weight > 0
    logarithm = np.log(np.where(used, weight, 1.0))
    profile = np.exp(logarithm.sum(axis=1) / np.maximum(used.sum(axis=1), 1))
    begins = np.arange(1, len(weight)) % PROJECTION.similar_lines == 0
    first = _first_lines(np.asarray(begins | (used[1:] != used[:-1]).any(axis=1)))
    variance = profile[:, None] / np.where(used, weight, np.inf)
    start = np.flatnonzero(first)
    mean = np.add.reduceat(variance, start) / np.diff(np.append(start, len(weight)))[:, None]
    level = np.where(mean > 0, 1 / np.maximum(mean, SAFE_DIVISOR), 0.0)
    return LineGroups(np.cumsum(first) - 1, profile, level)


def _first_lines(begins: BoolArray) -> BoolArray:
    """Return whether a line is the first of a group, (n_lines,), from the same of all lines but one."""
    return np.concatenate([[True], begins])

"""Plots of a study on given axes."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.results import Study, StudyCell


def errors(axes: "Axes", study: "Study", of: "Callable[[StudyCell], tuple[float, float] | None]") -> None:
    """Draw medians by level, a line for every division, with bars up to 90 %."""
    for name, cells in _by_division(study):
        pairs = [of(cell) or (np.nan, np.nan) for cell in cells]
        median, most = np.array(pairs).T
        bars = np.array([np.zeros(len(median)), most - median])
        axes.errorbar(_levels(axes, study), median, yerr=bars, marker="o", capsize=3, label=name)
    axes.set_ylim(bottom=0)  # not logarithmic: exact modes leave rounding, far below all else


def shares(axes: "Axes", study: "Study", of: "Callable[[StudyCell], float | None]") -> None:
    """Draw shares by level in per cent, a line for every division."""
    for name, cells in _by_division(study):
        values = [np.nan if of(cell) is None else 100.0 * (of(cell) or 0.0) for cell in cells]
        axes.plot(_levels(axes, study), values, marker="o", label=name)
    axes.set_ylim(-5, 105)


def _by_division(study: "Study") -> "list[tuple[str, Sequence[StudyCell]]]":
    names = [division.name for division in study.plan.divisions]
    return [(name, [cell for cell in study.cells if cell.division == name]) for name in names]


def _levels(axes: "Axes", study: "Study") -> FloatArray:
    levels = study.plan.levels
    places = np.arange(len(levels), dtype=float)
    axes.set_xticks(places, [level.name for level in levels])
    return places

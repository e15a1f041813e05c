"""Tracks of poles over the orders of a stabilisation chart."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.extraction.multi_mode.chart_settings import CHART
from modallab.extraction.multi_mode.global_method import Poles


def pole_tracks(poles: Poles) -> list[IntArray]:
    """Return the tracks of poles, each from the highest order down; each pole belongs to one track.

    Tracks begin at the highest order, where the poles of the structure are most precise. At each order a pole
    joins the track nearest to it if it is also the nearest pole of that track: two poles of one order never
    belong to one track, however close.
    """
    columns: list[list[int]] = []
    for order in poles.orders[::-1]:
        new = np.flatnonzero(poles.order == order)
        last = np.array([column[-1] for column in columns], int)
        joined = _assigned_tracks(poles, new, last)
        for pole, column in zip(new.tolist(), joined.tolist(), strict=True):
            if column >= 0:
                columns[column].append(pole)
            else:
                columns.append([pole])
    return [np.array(column) for column in columns]


def _assigned_tracks(poles: Poles, new: IntArray, last: IntArray) -> IntArray:
    """Return the track that each new pole joins, (n_new,), -1 for none; `last` are latest poles."""
    if not len(last) or not len(new):
        return np.full(len(new), -1)
    distance = _distance(poles, new, last)
    column = distance.argmin(axis=1)
    row = np.arange(len(new))
    mutual: BoolArray = distance.argmin(axis=0)[column] == row
    return np.where(mutual & (distance[row, column] <= 1), column, -1)


def _distance(poles: Poles, new: IntArray, last: IntArray) -> FloatArray:
    """Return the distance of every pole from every track, relative to the largest admissible one."""
    reach = np.maximum(
        -CHART.track_distance * poles.pole[last].real, CHART.track_distance_lines * 2 * np.pi * poles.spacing
    )
    return np.asarray(np.abs(poles.pole[new][:, None] - poles.pole[last]) / reach)

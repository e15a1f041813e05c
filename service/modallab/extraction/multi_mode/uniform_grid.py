"""Uniform grid for lines of any spacing, as polynomials in the z domain need it."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.extraction.multi_mode.chart_settings import UNIFORM_GRID
from modallab.extraction.multi_mode.global_method import GlobalMethod, Poles


def poles_of_lines(
    find: GlobalMethod, freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray
) -> Poles:
    """Return the poles that a global method finds in lines of any spacing; raises as that method.

    Each line is moved to the nearest point of a uniform grid; points without a line have weight 0. The
    spacing of the grid is the least spacing of the lines, or smaller if some lines would be too far from a
    point. If lines are not exactly at their points, the poles have errors of a part of that distance, and
    serve as starting values of a fit.

    Raises
    ------
    InvalidInputError
        If lines are so close somewhere, over so wide a range, that too many places were needed.
    """
    place = places(freq)
    n = int(place[-1]) + 1
    if n == len(freq):
        return find(freq, frf, weight, orders)
    grid = np.linspace(freq[0], freq[-1], n)
    grid_frf = np.zeros((n, *frf.shape[1:]), complex)
    grid_weight = np.zeros((n, *weight.shape[1:]))
    grid_frf[place], grid_weight[place] = frf, weight
    poles = find(grid, grid_frf, grid_weight, orders)
    # strengths are sums over lines, most of which are none
    strength = poles.strength * np.sqrt(len(freq) / n)
    return replace(poles, strength=strength, spacing=float(np.diff(freq).min()))


def places(freq: FloatArray) -> IntArray:
    """Return the place of every line, from 0 on, (n_lines,) rising.

    Parameters
    ----------
    freq
        (n_lines,) Hz, rising.
    """
    span, n = float(freq[-1] - freq[0]), len(freq)
    if n < 2 or np.abs(
        freq - np.linspace(freq[0], freq[-1], n)
    ).max() <= UNIFORM_GRID.rounding_tolerance * span / (n - 1):
        return np.arange(n)
    least = float(np.diff(freq).min())
    finest = min(UNIFORM_GRID.largest_subdivision, int(UNIFORM_GRID.largest_grid * least / span))
    for parts in range(1, finest + 1):
        exact = (freq - freq[0]) / span * round(span / least * parts)
        if np.abs(exact - exact.round()).max() <= UNIFORM_GRID.grid_tolerance or parts == finest:
            return np.asarray(exact.round().astype(int))
    raise InvalidInputError(
        "lines are too close together somewhere for so wide a range; "
        "take narrower bands, or methods of single modes",
        field="frequencies",
        value=least,
        allowed=bounds(span / UNIFORM_GRID.largest_grid, unit="Hz"),
    )

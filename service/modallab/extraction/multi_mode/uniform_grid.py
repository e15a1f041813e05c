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
    """Return the poles that a global method finds in lines of any spacing; parameters and errors as its.

    Lines are put at the nearest of evenly spaced places, of which those without a line have no weight. The
    places are as far apart as the nearest lines, or closer where that does not meet the others. Where
    they are met only nearly the poles are off by part of that, and serve to start a fit.

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

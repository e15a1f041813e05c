"""Lines in any spacing, put among evenly spaced ones as polynomials on a circle need them."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.extraction.multi_mode.global_method import GlobalMethod, Poles

EVEN = 0.01  # of the least spacing: what a line may be off its place
ROUNDED = 0.05  # of the spacing: even lines, written with few digits
FINEST = 8  # parts of the least spacing; a place is then off by a sixteenth of it at most
MOST_PLACES = 2**16  # bounds memory


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
    even = np.linspace(freq[0], freq[-1], n)
    apart_frf = np.zeros((n, *frf.shape[1:]), complex)
    apart_weight = np.zeros((n, *weight.shape[1:]))
    apart_frf[place], apart_weight[place] = frf, weight
    poles = find(even, apart_frf, apart_weight, orders)
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
    if n < 2 or np.abs(freq - np.linspace(freq[0], freq[-1], n)).max() <= ROUNDED * span / (n - 1):
        return np.arange(n)
    least = float(np.diff(freq).min())
    finest = min(FINEST, int(MOST_PLACES * least / span))
    for parts in range(1, finest + 1):
        exact = (freq - freq[0]) / span * round(span / least * parts)
        if np.abs(exact - exact.round()).max() <= EVEN or parts == finest:
            return np.asarray(exact.round().astype(int))
    raise InvalidInputError(
        "lines are too close together somewhere for so wide a range",
        field="frequencies",
        value=least,
        allowed=f"{span / MOST_PLACES:.3g} Hz apart or more; or narrower bands, or methods of single modes",
    )

"""Arrays as JSON, and the thinning of long curves."""

from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from fastapi import Query
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray, IntArray

Points = Annotated[int, Query(ge=2, le=20_000, description="lines of each curve, about")]


def thinned(magnitude: FloatArray, points: int) -> IntArray:
    """Return the indices of retained lines: the largest and the smallest magnitude of every stretch.

    Parameters
    ----------
    magnitude
        (n_freq, n_curves), none below zero.
    points
        Lines to keep, about; both ends always.
    """
    n_freq = len(magnitude)
    if n_freq <= points:
        return np.arange(n_freq)
    level = np.log(np.maximum(magnitude, np.finfo(float).tiny)).sum(axis=1)
    edges = np.linspace(0, n_freq, points // 2 + 1).astype(int)
    stretches = [(a, b) for a, b in pairwise(edges) if b > a]
    lines = {a + int(pick(level[a:b])) for a, b in stretches for pick in (np.argmax, np.argmin)}
    return np.array(sorted(lines | {0, n_freq - 1}))


def numbers(values: NDArray[Any]) -> Any:
    """Return an array as JSON has it: complex as [re, im], null for what is not finite."""
    if values.dtype.kind == "c":
        return numbers(np.stack([values.real, values.imag], axis=-1))
    if values.dtype.kind != "f" or np.isfinite(values).all():
        return values.tolist()
    entries = values.astype(object)
    entries[~np.isfinite(values)] = None
    return entries.tolist()

"""Stability of poles between successive model orders."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.correlation.mac import mac
from modallab.extraction.multi_mode.global_method import Poles


@dataclass(frozen=True)
class StabilisationTolerances:
    """How near two poles of neighbouring orders must be to be the same.

    One percent in frequency, five in damping and a MAC of 0.98 are in general use. One percent of a high
    frequency can be many half-power bandwidths, where any pole will do: the frequency must agree within a
    part of the bandwidth, too. Of a resonance much narrower than a line neither is known so well: there,
    parts of the line spacing are allowed.
    """

    frequency: float = 0.01  # of the frequency
    bandwidth: float = 0.2  # of the half-power bandwidth: of frequency
    frequency_lines: float = 0.1  # of the line spacing: of frequency, if that is more than `bandwidth` allows
    loss_factor: float = 0.05  # of the loss factor
    loss_factor_lines: float = (
        0.02  # of the line spacing: of the bandwidth, if more than `loss_factor` allows
    )
    vector: float = 0.02  # one less MAC


USUAL = StabilisationTolerances()


def stabilise(poles: Poles, tolerances: StabilisationTolerances = USUAL) -> IntArray:
    """Return how stable each pole is, (n_poles,): 0 new, 1 in frequency, 2 and in damping, 3 in vector too.

    It is held against all poles of the next lower order and has the level of the one it agrees with best.

    Parameters
    ----------
    poles
        Of rising orders, from a member of `GLOBAL_METHODS`.
    tolerances
        How near two poles must be.
    """
    levels = np.zeros(len(poles.order), int)
    for lower_order, higher_order in pairwise(poles.orders):
        old, new = np.flatnonzero(poles.order == lower_order), np.flatnonzero(poles.order == higher_order)
        if len(old) and len(new):
            levels[new] = _agreement(poles, old, new, tolerances).max(axis=1)
    return levels


def _agreement(poles: Poles, old: IntArray, new: IntArray, tolerances: StabilisationTolerances) -> IntArray:
    """Return the level of agreement of every new pole with every old one, (n_new, n_old)."""
    frequency, bandwidth = poles.frequency, poles.loss_factor * poles.frequency
    tolerance = np.maximum(tolerances.bandwidth * bandwidth, tolerances.frequency_lines * poles.spacing)
    in_frequency = _near(frequency, old, new, np.minimum(tolerance, tolerances.frequency * frequency))
    tolerance = np.maximum(tolerances.loss_factor * bandwidth, tolerances.loss_factor_lines * poles.spacing)
    in_damping = in_frequency & _near(bandwidth, old, new, tolerance)
    in_vector = in_damping & (mac(poles.vector[new].T, poles.vector[old].T) >= 1 - tolerances.vector)
    return np.asarray(in_frequency.astype(int) + in_damping + in_vector)


def _near(values: FloatArray, old: IntArray, new: IntArray, tolerance: FloatArray) -> BoolArray:
    return np.asarray(np.abs(values[new][:, None] - values[old]) <= tolerance[old])

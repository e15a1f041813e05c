"""Stability of poles between successive model orders."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.correlation.mac import mac
from modallab.extraction.multi_mode.global_method import Poles


@dataclass(frozen=True)
class StabilisationTolerances:
    """Tolerances between equal poles of successive orders.

    One per cent in frequency, five per cent in damping and a modal assurance criterion (MAC) of 0.98 are
    customary. One per cent of a high frequency can be many half-power bandwidths, so that a tolerance
    relative to the bandwidth is applied too. A resonance much narrower than a line is determined less
    precisely; tolerances relative to the line spacing apply there.
    """

    frequency: float = 0.01
    """1, difference in frequency over the frequency."""
    bandwidth: float = 0.2
    """1, difference in frequency over the half-power bandwidth."""
    frequency_lines: float = 0.1
    """1, difference in frequency over the line spacing, if larger than that by `bandwidth`."""
    loss_factor: float = 0.05
    """1, difference in loss factor over the loss factor."""
    loss_factor_lines: float = 0.02
    """1, difference in half-power bandwidth over the line spacing, if larger than that by `loss_factor`."""
    vector: float = 0.02
    """1, one minus the MAC of the residue vectors."""


USUAL = StabilisationTolerances()


def stabilise(poles: Poles, tolerances: StabilisationTolerances = USUAL) -> IntArray:
    """Return the stability level of each pole, (n_poles,).

    Level 0 is a new pole, 1 is stable in frequency, 2 in damping too, 3 in the vector of residues too. Each
    pole is compared with all poles of the next lower order; the highest level of agreement counts.

    Parameters
    ----------
    poles
        Poles at ascending orders, from a member of `GLOBAL_METHODS`.
    tolerances
        Tolerances between equal poles.
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

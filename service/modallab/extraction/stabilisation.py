"""How far the poles of one model order agree with those of the order before."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.global_method import Poles


@dataclass(frozen=True)
class Tolerances:
    """How near two poles of neighbouring orders must be to be the same.

    A structure's pole moves by its random error when an order is added, a computational one anywhere
    between its neighbours. The defaults are those in general use for frequency and damping.
    """

    frequency: float = 0.01  # of the frequency
    loss_factor: float = 0.05  # of the loss factor
    vector: float = 0.02  # one less MAC of the two vectors


USUAL = Tolerances()


def stabilise(poles: Poles, tolerances: Tolerances = USUAL) -> IntArray:
    """Return how stable every pole is, (n_poles,): 0 new, 1 in frequency, 2 and in damping, 3 in vector too.

    Each pole is held against the one nearest to it among the poles of the next lower order. Where the
    method gives no vectors, 3 is 2.

    Parameters
    ----------
    poles
        Of rising orders.
    tolerances
        How near two poles must be.
    """
    levels = np.zeros(len(poles.order), int)
    orders = np.unique(poles.order)
    for before, after in pairwise(orders):
        old, new = np.flatnonzero(poles.order == before), np.flatnonzero(poles.order == after)
        if len(old) and len(new):
            levels[new] = _agreement(poles, old, new, tolerances).max(axis=1)
    return levels


def _agreement(poles: Poles, old: IntArray, new: IntArray, tolerances: Tolerances) -> IntArray:
    """Return the level of agreement of every new pole with every old one, (n_new, n_old)."""
    frequency, loss_factor = poles.frequency, poles.loss_factor
    levels = _near(frequency, old, new, tolerances.frequency).astype(int)
    levels += (levels == 1) & _near(loss_factor, old, new, tolerances.loss_factor)
    alike = _mac(poles.vector[new], poles.vector[old]) >= 1 - tolerances.vector
    return np.asarray(levels + ((levels == 2) & alike))


def _near(values: FloatArray, old: IntArray, new: IntArray, tolerance: float) -> BoolArray:
    reference = np.abs(values[old])
    return np.asarray(np.abs(values[new][:, None] - values[old]) <= tolerance * reference)


def _mac(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the MAC of every pair of rows; 1 where rows are of no width."""
    if not first.shape[1]:
        return np.ones((len(first), len(second)))
    sizes = np.outer((np.abs(first) ** 2).sum(axis=1), (np.abs(second) ** 2).sum(axis=1))
    product = np.abs(first.conj() @ second.T) ** 2
    return np.asarray(np.divide(product, sizes, out=np.zeros(sizes.shape), where=sizes > 0))

"""Poles that are one mode whose frequency moves during the test."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.refinement_settings import SPLIT_MODES


@dataclass(frozen=True, eq=False)
class Merged:
    """Poles, some groups of which represent one mode each."""

    eigenvalue: ComplexArray
    """(n_modes,) (rad/s)^2, where poles stand for one mode their mean at the first of them."""
    redundant: BoolArray
    """(n_modes,) the others of them."""
    notes: tuple[str, ...] = ()
    """Drift of each such mode, as text."""


def merged_in_ranges(eigenvalue: ComplexArray, ranges: Sequence[tuple[float, float]]) -> Merged:
    """Return the poles with one in each range, Hz, through which a mode drifts from FRF to FRF.

    A common pole cannot follow such a mode, so that further poles beside it fit better, with shapes as
    different as those of a genuine pair: the shifts of the FRFs alone distinguish them.
    """
    mean, redundant = eigenvalue.copy(), np.zeros(len(eigenvalue), bool)
    frequency = np.sqrt(np.maximum(eigenvalue.real, 0.0)) / (2 * np.pi)
    for low, high in ranges:
        members = np.flatnonzero((frequency >= low) & (frequency <= high))
        if len(members) > 1:
            mean[members[0]] = eigenvalue[members].mean()
            redundant[members[1:]] = True
    return Merged(mean, redundant)


def merged_of_one_shape(fit: ModalFit, inside: BoolArray) -> Merged:
    """Return the poles, with one in place of two of one shape that are a small part of a bandwidth apart.

    A mode whose frequency moves while all FRFs are measured is a mean over its frequencies, which two poles
    fit better than one. Two modes of a structure so close together have different shapes.

    Parameters
    ----------
    fit
        Fit of all modes, in ascending frequency.
    inside
        (n_modes,) which poles may be modes.
    """
    mean, redundant, notes = fit.eigenvalue.copy(), np.zeros(len(inside), bool), []
    if fit.modal_constant.shape[1] < SPLIT_MODES.least_frfs:
        return Merged(mean, redundant)
    for pair in pairwise(np.flatnonzero(inside).tolist()):
        rows = list(pair)
        frequency, constant = fit.frequency[rows], fit.modal_constant[rows]
        separation = np.diff(frequency)[0] / (fit.loss_factor[rows] * frequency).max()
        if redundant[rows[0]] or not separation < SPLIT_MODES.bandwidths or not _alike(constant):
            continue
        size = np.linalg.norm(constant, axis=1)
        share = size / size.sum()
        mean[rows[0]] = share @ fit.eigenvalue[rows]
        redundant[rows[1]] = True
        # the standard deviation of a steady drift is its range over the root of 12
        drift = 100 * np.sqrt(12 * share.prod()) * (frequency[1] / frequency[0] - 1)
        notes.append(
            f"mode at {frequency @ share:.5g} Hz: its frequency drifts by about {drift:.2g} % during the "
            f"test, as two poles of one shape {separation:.2g} bandwidths apart show"
        )
    return Merged(mean, redundant, tuple(notes))


def _alike(constant: ComplexArray) -> bool:
    """Return whether two rows of modal constants are one shape."""
    power = (np.abs(constant) ** 2).sum(axis=1).prod()
    criterion = np.abs(constant[0].conj() @ constant[1]) ** 2 / max(power, SAFE_DIVISOR)
    return bool(criterion > SPLIT_MODES.least_mac)

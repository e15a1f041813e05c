"""Recognition of FRFs that were measured before: cut, rescaled, rounded, or of another kind."""

import numpy as np

from modallab.assignments.settings import RECOGNITION
from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.frf import FrfSet

_STEPS = (-2, -1, 0, 1, 2)  # between kinds of FRF: factors of i omega


def is_copy(frf: FrfSet, known: FrfSet) -> bool:
    """Return whether an FRF of a set is one of the known set: their ratio is a number times (i omega)^n.

    At random errors of their own, two measurements of the same structure are none of each other.

    Parameters
    ----------
    frf
        FRFs of any lines, DoFs, scales and kind.
    known
        FRFs as they were measured.
    """
    rows, known_rows = _common_lines(frf.freq, known.freq)
    if len(rows) < RECOGNITION.fewest_lines:
        return False
    values = frf.values[rows].reshape(len(rows), -1)
    known_values = known.values[known_rows].reshape(len(rows), -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = values[:, :, None] / known_values[:, None, :]
        omega = (known.freq[known_rows] / known.freq[known_rows].max())[:, None, None]
        return any((_scatter(ratios * omega**step) < RECOGNITION.scatter).any() for step in _STEPS)


def _common_lines(freq: FloatArray, known: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the indices of equal lines above 0 Hz in both, evenly chosen where there are many."""
    nearest = np.abs(known[None, :] - freq[:, None]).argmin(axis=1) if len(known) else np.zeros(0, int)
    spacing = np.diff(known).min() if len(known) > 1 else 1.0
    equal = (np.abs(known[nearest] - freq) < RECOGNITION.frequency * spacing) & (known[nearest] > 0)
    rows = np.flatnonzero(equal)
    rows = rows[:: max(1, len(rows) // RECOGNITION.most_lines)]
    return rows, nearest[rows]


def _scatter(ratios: ComplexArray) -> FloatArray:
    """Return the scatter of ratios (n_lines, ..) about their median, which most lines do not exceed."""
    centre = np.median(ratios.real, axis=0) + 1j * np.median(ratios.imag, axis=0)
    scatter = np.quantile(np.abs(ratios / centre - 1), RECOGNITION.share, axis=0)
    return np.where(np.isnan(scatter), np.inf, scatter)

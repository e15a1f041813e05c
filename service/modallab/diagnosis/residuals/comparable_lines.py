"""Lines of a measurement that a prediction can be compared with."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.rig.analyser import Analyser
from modallab.rig.excitation import EXCITATIONS


def comparable_lines(analyser: Analyser, freq: FloatArray, *, mean_kept: bool) -> BoolArray:
    """Return the lines (n_freq,) above 0 Hz that the source drives and that hold all of their power.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    mean_kept
        Whether the analyser is known not to subtract the mean of a record.
    """
    lines = _driven(analyser, freq)
    return lines if mean_kept else lines & _beyond_mean(analyser, freq)


def _driven(analyser: Analyser, freq: FloatArray) -> BoolArray:
    """Return the lines (n_freq,) above 0 Hz that the source drives, in full with the window's neighbours."""
    if analyser.excitation.band is None:
        return np.asarray(freq > 0)
    first, last = (line * analyser.spacing for line in analyser.driven_lines)
    mixed = RANDOM_ERROR.window_reach * analyser.spacing
    margin = mixed if EXCITATIONS[analyser.excitation.kind].continuous > 0 else 0.0
    tolerance = RANDOM_ERROR.line_tolerance * analyser.spacing
    low, high = first + margin - tolerance, last - margin + tolerance
    return np.asarray((freq > 0) & (freq >= low) & (freq <= high))


def _beyond_mean(analyser: Analyser, freq: FloatArray) -> BoolArray:
    """Return the lines (n_freq,) to which the window carries nothing of 0 Hz.

    Many analysers subtract the mean of every record, and no file tells which. Nearer lines lose by it what
    the window carried to 0 Hz.
    """
    reach = len(analyser.line_window.coefficients) - 1
    return np.asarray(freq > (reach + RANDOM_ERROR.line_tolerance) * analyser.spacing)

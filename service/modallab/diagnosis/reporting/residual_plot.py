"""What a prediction leaves of a measurement, drawn in units of its random error."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.reporting import svg

POINTS = 400  # of a curve, about: as many as there is room for
LEAST = 1e-2  # random errors that the axis begins at or above


def differences(freq: FloatArray, before: FloatArray, after: FloatArray, title: str, added: bool) -> str:
    """Return a chart of differences by frequency, before and after; where nothing is known they are NaN.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    before, after
        (n_freq,) in random errors.
    added
        Whether anything was added, so that there is an after.
    """
    off = [np.log10(np.maximum(one, LEAST)) for one in (before, after)]
    x, (first, last) = svg.thinned(freq, off, POINTS)
    top = max(1.0, float(np.nanmax(np.concatenate([first, last]), initial=1.0)))
    frame = svg.Frame(svg.frequencies(freq), svg.decades(-1.0, top, "random errors"), height=140.0)
    marks = [
        svg.line(frame, x, first, "before"),
        svg.line(frame, x, last, "left") if added else "",
        svg.level(frame, 0.0, "one"),
    ]
    return svg.chart(frame, title, marks)

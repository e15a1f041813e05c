"""Chart of the residual over frequency, in random errors."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.settings import DRAWING


def residual_chart(freq: FloatArray, initial: FloatArray, final: FloatArray, title: str, added: bool) -> str:
    """Return a chart of residuals over frequency, of the initial and the final prediction.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    initial, final
        (n_freq,) residuals in random errors; nan where they are not defined.
    added
        Whether effects were added; if not, only the initial prediction is drawn.
    """
    logs = [np.log10(np.maximum(values, DRAWING.least_residual)) for values in (initial, final)]
    x, (first, last) = svg.thinned(freq, logs, DRAWING.curve_points)
    top = max(1.0, float(np.nanmax(np.concatenate([first, last]), initial=1.0)))
    frame = svg.Frame(svg.frequencies(freq), svg.decades(-1.0, top, "random errors"), height=140.0)
    marks = [
        svg.line(frame, x, first, "before"),
        svg.line(frame, x, last, "left") if added else "",
        svg.level(frame, 0.0, "one"),
    ]
    return svg.chart(frame, title, marks)

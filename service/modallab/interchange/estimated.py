"""Averages and random errors of a file that states none, from the scatter of its lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.assumption import Assumption
from modallab.core.numerics import SAFE_DIVISOR
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.line_scatter import estimated_averages, estimated_error
from modallab.estimation.partial_coherence import partial_coherence
from modallab.estimation.windows import Window
from modallab.interchange.file_content import FileContent
from modallab.interchange.settings import READING
from modallab.rig.analyser import Analyser


@dataclass(frozen=True)
class EstimatedAverages:
    """Effective averages of a file: declared, or else estimated."""

    value: float
    """1, effective number of averages."""
    assumed: tuple[Assumption, ...] = ()
    """What is assumed of them, with the reason; none where they are declared."""
    correlation: ErrorCorrelation | None = None
    """Correlation of the errors of neighbouring lines; None if there is no random error."""
    standard_error: float | None = None
    """1, of the value; None if unknown."""


def averages_of(content: FileContent, window: Window | None) -> EstimatedAverages:
    """Return the effective averages of a file that states none.

    Parameters
    ----------
    window
        Window of the records; None: not declared.

    Raises
    ------
    InvalidInputError
        If there is a coherence, and too few lines to tell its averages.
    """
    usual = float(Analyser().simulated_averages)
    if content.coherence is None:
        reason = "nothing tells them; without coherence no random error follows from them"
        return EstimatedAverages(usual, (Assumption("averages", f"{usual:g}", reason),))
    values, coherence = _above_rest(content)
    estimate = estimated_averages(values, coherence, window)
    if estimate is None:
        reason = "nothing tells them; a coherence of 1 has no random error"
        return EstimatedAverages(usual, (Assumption("averages", f"{usual:g}", reason),))
    averages = min(estimate.value, READING.max_stated_averages)
    text = f"{averages:.4g} +- {estimate.standard_error:.2g}"
    reason = "estimated from coherence and the scatter of neighbouring lines; `averages` declares them"
    assumed = (Assumption("averages", text, reason),)
    return EstimatedAverages(averages, assumed, estimate.correlation, estimate.standard_error)


def random_error_of(content: FileContent, window: Window | None) -> tuple[Assumption, ...]:
    """Return the random error that the scatter of lines shows, of a file without coherence."""
    if content.coherence is not None:
        return ()
    estimates = estimated_error(_above_rest(content)[0], window)
    if estimates is None:
        return ()
    errors = [estimate.value for estimate in estimates]
    uncertainty = np.median([e.standard_error / max(e.value, SAFE_DIVISOR) for e in estimates])
    text = f"{min(errors):.2g} to {max(errors):.2g} of the median of an FRF, +- {100 * uncertainty:.0f} %"
    reason = "estimated from the scatter of neighbouring lines; `noise_floor` of a request states it"
    return (Assumption("random_error", text, reason),)


def _above_rest(content: FileContent) -> tuple[ComplexArray, FloatArray]:
    """Return FRFs and coherence of the lines above 0 Hz, (n_freq, n_frf) each."""
    values, coherence = np.asarray(content.frf.values, complex), content.coherence
    if coherence is None:
        coherence = np.ones(values.shape)
    elif coherence.ndim == 2:
        coherence = partial_coherence(values, coherence)
    above = content.frf.freq > 0
    n = int(above.sum())
    return values[above].reshape(n, -1), coherence[above].reshape(n, -1)

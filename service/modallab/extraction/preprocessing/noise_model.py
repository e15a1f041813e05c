"""What the random errors of lines have in common beyond their variance."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.correlated_lines import CorrelatedLines
from modallab.extraction.preprocessing.line_noise import coherence_correction
from modallab.extraction.preprocessing.responses import Responses


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """Correlation of the errors of lines, and their part by noise of the force.

    Noise of the force gives an FRF an error with the phase of the FRF, in proportion to it; FRFs that were
    recorded together have this relative error in common. Noise of a response gives an error of its own.
    """

    correlated: CorrelatedLines | None = None
    """Correlation of lines by the window of the records; None: lines are independent."""
    force_share: FloatArray | None = None
    """(n_lines, n_frf) part of the variance by noise of the force, 0 to 1; None: not known."""
    force_variance: FloatArray | None = None
    """(n_lines,) relative variance by noise of the force; None: not known."""

    @classmethod
    def of(cls, responses: Responses, lines: slice) -> Self:
        """Return the model of some lines of all FRFs."""
        correlation, noise = responses.correlation, responses.noise
        correlated = None if correlation is None else CorrelatedLines.of(responses.freq[lines], correlation)
        if noise is None:
            return cls(correlated)
        noise, n = noise.at(lines), responses.averages
        return cls(correlated, noise.force_share, coherence_correction(n) / n * noise.force)


INDEPENDENT_LINES = NoiseModel()


def with_conjugate_phase(values: ComplexArray, response: ComplexArray) -> ComplexArray:
    """Return the values with the phase of the conjugate response; unchanged where that is zero."""
    size = np.abs(response)
    return np.asarray(values * np.where(size > 0, response.conj() / np.where(size > 0, size, 1.0), 1.0))

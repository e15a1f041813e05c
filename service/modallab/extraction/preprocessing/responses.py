"""FRFs in the form that extraction uses: receptance above 0 Hz, with the random error of each line."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import frf_names
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.partial_coherence import partial_coherence
from modallab.extraction.options import MIN_LINES
from modallab.extraction.preprocessing.bands import coherent_lines
from modallab.extraction.preprocessing.fit_windows import line_variance
from modallab.extraction.preprocessing.noise_ratios import NoiseToSignal
from modallab.extraction.preprocessing.settings import RESPONSES


@dataclass(frozen=True, eq=False)
class Responses:
    """FRFs between many DoFs and a few references: drive points, or responses if the hammer roves.

    FRFs are ordered by DoF and, for each DoF, by reference.
    """

    freq: FloatArray
    """(n_freq,) Hz, above 0."""
    receptance: ComplexArray
    """(n_freq, n_frf) m/N."""
    coherence: FloatArray
    """(n_freq, n_frf), 1 where it was not measured."""
    averages: float
    """Effective number of averages."""
    dofs: tuple[Dof, ...]
    """(n_dof,) measured degrees of freedom."""
    references: tuple[Dof, ...]
    """(n_ref,) reference degrees of freedom."""
    correlation: ErrorCorrelation | None = None
    """Correlation of the random errors of lines by the window; None: lines are independent."""
    noise: NoiseToSignal | None = None
    """Noise of force and responses as coherence shows it; None: not known."""

    @property
    def mobility(self) -> ComplexArray:
        """(n_freq, n_frf) m/(s N), coherent part: multiplied by the root of the coherence."""
        return np.asarray(2j * np.pi * self.freq[:, None] * self.receptance * np.sqrt(self.coherence))

    @property
    def coherent(self) -> BoolArray:
        """(n_freq,) True where some FRF is more coherent than noise would be."""
        return coherent_lines(self.coherence, self.averages)

    @property
    def variance(self) -> FloatArray:
        """(n_freq, n_frf) E|error|^2 of receptance, infinite where nothing is coherent."""
        return line_variance(self.receptance, self.coherence, self.averages)

    @property
    def drive_row(self) -> int | None:
        """Index of the drive-point FRF; None if there is none, or if there are several references."""
        row = int(self.driving[0])
        return row if len(self.references) == 1 and row >= 0 else None

    @property
    def driving(self) -> IntArray:
        """(n_ref,) index of the DoF at the point of each reference, -1 if there is none."""
        return driving_rows(self.dofs, self.references)

    @property
    def senses(self) -> IntArray:
        """(n_ref,) -1 where that DoF and the reference have opposite directions, else 1."""
        pairs = zip(self.driving.tolist(), self.references, strict=True)
        return np.array([self.dofs[i].sign * r.sign if i >= 0 else 1 for i, r in pairs], np.int64)

    @property
    def frfs(self) -> tuple[str, ...]:
        """(n_frf,) names of the FRFs."""
        return frf_names(self.dofs, self.references)


def driving_rows(dofs: Sequence[Dof], references: Sequence[Dof]) -> IntArray:
    """Return the index of the DoF at the point of each reference, (n_ref,), -1 if there is none."""
    points = [dof.point for dof in dofs]
    return np.array([points.index(r.point) if r.point in points else -1 for r in references], int)


def responses_of(frf: FrfSet, coherence: FloatArray | None, averages: float) -> Responses:
    """Return a set of FRFs in the form that extraction uses.

    Parameters
    ----------
    frf
        Of any kind. The fewer of its inputs and outputs are the references.
    coherence
        (n_freq, n_out), multiple if there are several inputs, or (n_freq, n_out, n_in), ordinary; None if it
        was not measured.
    averages
        Effective number of averages of the coherence.

    Raises
    ------
    InvalidInputError
        If shapes, number of averages or size of the FRFs are not admissible.
    """
    if not averages > 0:
        raise InvalidInputError(
            "averages must be above zero",
            field="averages",
            value=averages,
            allowed=bounds(exclusive_minimum=0),
        )
    frf_coherence = _coherence(frf, coherence)
    positive = frf.freq > 0
    usable = frf.between(0.0, np.inf).to(FrfKind.RECEPTANCE)
    force_roves = len(frf.outputs) < len(frf.inputs)  # few responses to many force points
    dofs, references = (frf.inputs, frf.outputs) if force_roves else (frf.outputs, frf.inputs)
    order = (0, 2, 1) if force_roves else (0, 1, 2)
    values = usable.values.transpose(order).reshape(len(usable.freq), -1)
    largest = float(np.abs(values).max(initial=0.0))
    if (
        largest and not 1 / RESPONSES.largest_receptance < largest < RESPONSES.largest_receptance
    ):  # their squares must still be numbers
        raise InvalidInputError(
            "the FRFs have no physical magnitude",
            field="values",
            value=largest,
            allowed=bounds(exclusive_maximum=RESPONSES.largest_receptance, unit="m/N"),
        )
    if len(usable.freq) < MIN_LINES:
        raise InvalidInputError(
            "too few lines above 0 Hz", field="freq", value=len(usable.freq), allowed=bounds(MIN_LINES)
        )
    frf_coherence = frf_coherence[positive].transpose(order).reshape(values.shape)
    return Responses(usable.freq, values, frf_coherence, averages, dofs, references)


def _coherence(frf: FrfSet, coherence: FloatArray | None) -> FloatArray:
    """Return the coherence of each FRF, validated and at most 1; 1 where it was not measured."""
    n_freq, n_out, n_in = frf.values.shape
    if coherence is None:
        return np.ones(frf.values.shape)
    if coherence.shape not in ((n_freq, n_out), (n_freq, n_out, n_in)):
        raise InvalidInputError(
            "coherence does not fit the FRFs",
            field="coherence",
            value=str(coherence.shape),
            allowed=str((n_freq, n_out, n_in)),
        )
    invalid = ~((coherence >= 0) & (coherence <= 1 + COMPARISON_ROUNDING))
    if invalid.any():
        raise InvalidInputError(
            "coherence must lie from 0 to 1",
            field="coherence",
            value=float(coherence[invalid][0]),
            allowed=bounds(0, 1),
        )
    bounded = np.minimum(coherence, 1.0)
    incoherent = 1 - bounded
    if (incoherent > 0).any():
        # A 1 among others is rounded: the mean of all that is closer to 1 than the closest of these.
        least = float(incoherent[incoherent > 0].min())
        bounded = np.where(incoherent > 0, bounded, 1 - least / 2)
    return bounded if bounded.ndim == 3 else partial_coherence(frf.values, bounded)

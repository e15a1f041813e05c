"""Measured responses as extraction reads them: receptance above 0 Hz, with the random error of each line."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import frf_names
from modallab.extraction.options import MIN_LINES
from modallab.extraction.preprocessing.bands import coherent_lines
from modallab.extraction.preprocessing.fit_windows import line_variance
from modallab.extraction.preprocessing.multiple_coherence import of_each_force

LARGEST = 1e60  # m/N


@dataclass(frozen=True, eq=False)
class Responses:
    """FRFs between many points and a few, the references: drive points, or responses while the drive roves.

    FRFs are counted DoF by DoF, at each of them reference by reference.
    """

    freq: FloatArray  # (n_freq,) Hz, above 0
    receptance: ComplexArray  # (n_freq, n_frf) m/N
    coherence: FloatArray  # (n_freq, n_frf), 1 where it was not measured
    averages: float
    dofs: tuple[Dof, ...]  # (n_dof,)
    references: tuple[Dof, ...]  # (n_ref,)

    @property
    def mobility(self) -> ComplexArray:
        """(n_freq, n_frf) m/(s N), the coherent part: times the root of the coherence."""
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
        """Which of the FRFs is that of the drive point; None if none is, or of several references."""
        row = int(self.driving[0])
        return row if len(self.references) == 1 and row >= 0 else None

    @property
    def driving(self) -> IntArray:
        """(n_ref,) which of the DoFs is at the point of each reference, -1 if none is."""
        return driving_rows(self.dofs, self.references)

    @property
    def senses(self) -> IntArray:
        """(n_ref,) -1 where that DoF and the reference point opposite ways, else 1."""
        pairs = zip(self.driving.tolist(), self.references, strict=True)
        return np.array([self.dofs[i].sign * r.sign if i >= 0 else 1 for i, r in pairs], np.int64)

    @property
    def frfs(self) -> tuple[str, ...]:
        """(n_frf,) their names."""
        return frf_names(self.dofs, self.references)


def driving_rows(dofs: Sequence[Dof], references: Sequence[Dof]) -> IntArray:
    """Return which of the DoFs is at the point of each reference, (n_ref,), -1 if none is."""
    points = [dof.point for dof in dofs]
    return np.array([points.index(r.point) if r.point in points else -1 for r in references], int)


def responses_of(frf: FrfSet, coherence: FloatArray | None, averages: float) -> Responses:
    """Return what extraction reads from a set of FRFs.

    Parameters
    ----------
    frf
        Of any kind. The fewer of its inputs and outputs are the references.
    coherence
        (n_freq, n_out), multiple if there are several inputs, or (n_freq, n_out, n_in), ordinary; None where
        it was not measured.
    averages
        Effective number of averages behind the coherence.

    Raises
    ------
    InvalidInputError
        If the inputs do not fit together.
    """
    if not averages > 0:
        raise InvalidInputError(
            "averages must be above zero", field="averages", value=averages, allowed="> 0"
        )
    trust = _coherence(frf, coherence)
    above = frf.freq > 0
    usable = frf.between(0.0, np.inf).to(FrfKind.RECEPTANCE)
    roved = len(frf.outputs) < len(frf.inputs)  # by the force: few listen to many
    dofs, references = (frf.inputs, frf.outputs) if roved else (frf.outputs, frf.inputs)
    order = (0, 2, 1) if roved else (0, 1, 2)
    values = usable.values.transpose(order).reshape(len(usable.freq), -1)
    size = float(np.abs(values).max(initial=0.0))
    if size and not 1 / LARGEST < size < LARGEST:  # their squares must still be numbers
        raise InvalidInputError(
            "the FRFs are of no physical size", field="values", value=size, allowed=f"below {LARGEST:g} m/N"
        )
    if len(usable.freq) < MIN_LINES:
        raise InvalidInputError(
            "too few lines", field="freq", value=len(usable.freq), allowed=f"at least {MIN_LINES} above 0 Hz"
        )
    trust = trust[above].transpose(order).reshape(values.shape)
    return Responses(usable.freq, values, trust, averages, dofs, references)


def _coherence(frf: FrfSet, coherence: FloatArray | None) -> FloatArray:
    """Return the coherence of each FRF, shaped as they are, checked; 1 where it is not known."""
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
    bad = ~((coherence >= 0) & (coherence <= 1 + 1e-9))
    if bad.any():
        raise InvalidInputError(
            "coherence must lie from 0 to 1",
            field="coherence",
            value=float(coherence[bad][0]),
            allowed="0 to 1",
        )
    known = np.minimum(coherence, 1.0)
    return known if known.ndim == 3 else of_each_force(frf.values, known)

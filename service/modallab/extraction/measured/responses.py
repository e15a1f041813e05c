"""Measured responses as extraction reads them: receptance above 0 Hz, with the random error of each line."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.measured.bands import coherent_lines
from modallab.extraction.measured.windows import line_variance
from modallab.extraction.options import MIN_LINES

LARGEST = 1e60  # m/N


@dataclass(frozen=True, eq=False)
class Responses:
    """FRFs between some points and one that is the same in all: a drive point, or a response while the
    drive roves."""

    freq: FloatArray  # (n_freq,) Hz, above 0
    receptance: ComplexArray  # (n_freq, n_frf) m/N
    coherence: FloatArray  # (n_freq, n_frf), 1 where it was not measured
    averages: float
    dofs: tuple[Dof, ...]  # (n_frf,) the point that differs
    drive: Dof  # the point that does not

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
        """Which of the FRFs is that of the drive point, None if none is."""
        return next((i for i, dof in enumerate(self.dofs) if dof.point == self.drive.point), None)


def responses_of(frf: FrfSet, coherence: FloatArray | None, averages: float) -> Responses:
    """Return what extraction reads from a set of FRFs.

    Parameters
    ----------
    frf
        One drive point and many responses, or one response and a roving drive point; any kind.
    coherence
        (n_freq, n_out), or (n_freq, n_out, n_in); None where it was not measured.
    averages
        Effective number of averages behind the coherence.

    Raises
    ------
    InvalidInputError
        If the inputs do not fit together.
    """
    n_out, n_in = len(frf.outputs), len(frf.inputs)
    if min(n_out, n_in) != 1:
        raise InvalidInputError(
            "modes are read from one drive point, or one response with a roving drive point",
            field="inputs",
            value=f"{n_out} x {n_in}",
            allowed="one input or one output",
        )
    if not averages > 0:
        raise InvalidInputError(
            "averages must be above zero", field="averages", value=averages, allowed="> 0"
        )
    trust = _coherence(frf, coherence)
    above = frf.freq > 0
    usable = frf.between(0.0, np.inf).to(FrfKind.RECEPTANCE)
    values = usable.values.reshape(len(usable.freq), -1)
    size = float(np.abs(values).max(initial=0.0))
    if size and not 1 / LARGEST < size < LARGEST:  # their squares must still be numbers
        raise InvalidInputError(
            "the FRFs are of no physical size", field="values", value=size, allowed=f"below {LARGEST:g} m/N"
        )
    if len(usable.freq) < MIN_LINES:
        raise InvalidInputError(
            "too few lines", field="freq", value=len(usable.freq), allowed=f"at least {MIN_LINES} above 0 Hz"
        )
    roving, fixed = (frf.outputs, frf.inputs[0]) if n_in == 1 else (frf.inputs, frf.outputs[0])
    return Responses(usable.freq, values, trust[above], averages, roving, fixed)


def _coherence(frf: FrfSet, coherence: FloatArray | None) -> FloatArray:
    """Return the coherence, (n_freq, n_frf), checked; 1 where it is not known."""
    n_freq, n_out, n_in = frf.values.shape
    if coherence is None:
        return np.ones((n_freq, n_out * n_in))
    if coherence.shape not in ((n_freq, n_out), (n_freq, n_out, n_in)) or (
        coherence.size != n_freq * n_out * n_in
    ):
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
    return np.minimum(coherence, 1.0).reshape(n_freq, -1)

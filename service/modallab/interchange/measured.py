"""Measured FRFs from a file of any format, and the measurement that they form with a log book."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.interchange.settings import READING
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Exciter
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

NO_LOG_BOOK = "no log book: the rig is what the file itself tells"
NO_COHERENCE = (
    "no coherence, which with averages tells random error: that of modes is told by what their fits leave; "
    "a diagnosis, or an update on FRFs, asks for a noise_floor"
)


@dataclass(frozen=True, eq=False)
class MeasuredFile:
    """FRFs with coherence and spectra from a file, without a rig."""

    frf: FrfSet
    coherence: FloatArray | None = None
    """(n_freq, n_out), or of each FRF (n_freq, n_out, n_in)."""
    averages: float | None = None
    """Effective number of averages."""
    force_spectrum: FloatArray | None = None
    """N^2/Hz, (n_freq, n_out, n_in), auto spectrum of the force."""
    response_spectrum: FloatArray | None = None
    """unit^2/Hz, shaped as `coherence`, auto spectra of the responses."""
    notes: tuple[str, ...] = ()
    axis_error: float = READING.axis_error  # relative error that the format leaves in the frequencies

    def __post_init__(self) -> None:
        arrays = {
            "values": self.frf.values,
            "force_spectrum": self.force_spectrum,
            "response_spectrum": self.response_spectrum,
        }
        for name, array in arrays.items():
            largest = 0.0 if array is None else float(np.abs(array).max(initial=0.0))
            if largest > READING.max_magnitude:
                raise InvalidInputError(
                    f"{name} holds a number of no size that can be computed with",
                    field=name,
                    value=largest,
                    allowed=bounds(maximum=READING.max_magnitude),
                )

    def on_rig(self, setup: RigSetup, averages: float | None = None) -> Measurement:
        """Return the measurement on a rig with a log book.

        Parameters
        ----------
        setup
            The log book of the test; responses that the file lacks are dropped from it. The
            frequencies are the analyser's, of which the file may hold a rounded copy, and may lack 0 Hz.
        averages
            Effective averages; by default the file's, or else the rig's.

        Raises
        ------
        InvalidInputError
            If the file contradicts the rig, or its arrays do not fit together.
        """
        counts = (averages, self.averages, setup.analyser.averages)
        return Measurement(
            frf=replace(self.frf, freq=self._axis(setup)),
            coherence=self._shaped(self.coherence, setup),
            averages=float(next(count for count in counts if count is not None)),
            setup=replace(setup, responses=self._responses(setup)),
            force_spectrum=self.force_spectrum,
            response_spectrum=self._shaped(self.response_spectrum, setup),
            notes=("imported", *self._missing_data_notes(), *self.notes),
        )

    def without_log_book(self, averages: float | None = None) -> Measurement:
        """Return the measurement without a log book.

        Drive points and responses of its rig are those of the file. The analyser has the lines of the file,
        approximately if they are not uniform from 0 Hz, and a rectangular window without leakage.

        Raises
        ------
        InvalidInputError
            If the file's arrays do not fit together.
        """
        counts = (averages, self.averages, Analyser.averages)
        effective_averages = float(next(count for count in counts if count is not None))
        setup = RigSetup(
            drives=self.frf.inputs,
            responses=self.frf.outputs,
            exciter=Exciter(kind="hammer" if len(self.frf.inputs) > 1 else "shaker"),
            analyser=self._analyser(effective_averages),
        )
        return Measurement(
            frf=self.frf,
            coherence=self._shaped(self.coherence, setup),
            averages=effective_averages,
            setup=setup,
            force_spectrum=self.force_spectrum,
            response_spectrum=self._shaped(self.response_spectrum, setup),
            notes=("imported", NO_LOG_BOOK, *self._missing_data_notes(), *self.notes),
        )

    def _missing_data_notes(self) -> tuple[str, ...]:
        return (NO_COHERENCE,) if self.coherence is None else ()

    def _analyser(self, averages: float) -> Analyser:
        freq = self.frf.freq
        if len(freq) < READING.min_lines:
            raise InvalidInputError(
                "too few lines", field="freq", value=len(freq), allowed=bounds(READING.min_lines)
            )
        spacing = float(np.median(np.diff(freq)))
        n_lines = round(float(freq[-1]) / spacing) + 1
        return Analyser(
            frequency_max=float(freq[-1]),
            n_lines=min(max(n_lines, READING.min_lines), READING.max_lines),
            averages=round(min(max(averages, 1.0), READING.max_averages)),
        )

    def _shaped(self, array: FloatArray | None, setup: RigSetup) -> FloatArray | None:
        """Return an array of each response, or of each FRF where a hammer roved."""
        roved = setup.exciter.kind == "hammer" and len(self.frf.inputs) > 1
        if array is None or array.ndim < 3 or roved or not (array == array[:, :, :1]).all():
            return array
        return array[:, :, 0]

    def _responses(self, setup: RigSetup) -> tuple[Dof, ...]:
        if self.frf.inputs != setup.drives:
            raise InvalidInputError(
                "the file drives elsewhere than the rig",
                field="inputs",
                value=list(map(str, self.frf.inputs)),
                allowed=list(map(str, setup.drives)),
            )
        strange = [str(dof) for dof in self.frf.outputs if dof not in setup.responses]
        if strange:
            raise InvalidInputError(
                "the file holds responses that the rig does not have",
                field="outputs",
                value=list(strange),
                allowed=list(map(str, setup.responses)),
            )
        return self.frf.outputs

    def _axis(self, setup: RigSetup) -> FloatArray:
        freq, lines = self.frf.freq, setup.analyser.freq
        if len(freq) == len(lines) - 1:  # receptance at rest is often no number
            lines = lines[1:]
        if len(lines) != len(freq) or not np.allclose(
            lines, freq, rtol=self.axis_error, atol=1e-6 * lines[1]
        ):
            raise InvalidInputError(
                "the file's frequency axis is not the analyser's",
                field="freq",
                value=f"{len(freq)} lines from {freq[0]:g} to {freq[-1]:g} Hz",
                allowed=f"{len(setup.analyser.freq)} lines from 0 to {lines[-1]:g} Hz, or all but 0 Hz",
            )
        return lines

"""Measured FRFs from a file of any format, and the measurement that they form with a log book."""

from dataclasses import dataclass, replace

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.estimation.windows import WINDOWS, Window
from modallab.interchange.declared import NOTHING_DECLARED, DeclaredTest
from modallab.interchange.estimated import EstimatedAverages, averages_of, random_error_of
from modallab.interchange.file_content import FileContent
from modallab.interchange.frequency_axis import analyser_of, lines_on
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

NO_LOG_BOOK = "no log book: the rig is what the file itself tells"
NO_COHERENCE = (
    "no coherence, which with averages tells random error: that of modes is told by what their fits leave, "
    "that of FRFs by the scatter of neighbouring lines; an update on FRFs asks for a noise_floor"
)


@dataclass(frozen=True, eq=False)
class MeasuredFile(FileContent):
    """Content of a file that becomes a measurement."""

    def on_rig(self, setup: RigSetup, declared: DeclaredTest = NOTHING_DECLARED) -> Measurement:
        """Return the measurement on a rig with a log book.

        Parameters
        ----------
        setup
            The log book of the test; responses, and blows of a roving hammer, that the file lacks are
            dropped from it, and the order is that of the file. The frequencies are the analyser's, of
            which the file may hold a rounded copy, or part of them.
        declared
            Effective averages; by default the file's, or else the rig's.

        Raises
        ------
        InvalidInputError
            If the file contradicts the rig, or its arrays do not fit together.
        """
        declared.check_against(setup)
        averages, assumed = self._averages(declared, setup.analyser.averages, setup.analyser.line_window)
        return Measurement(
            frf=replace(self.frf, freq=lines_on(setup.analyser, self.frf.freq, self.axis_error)),
            coherence=self._shaped(self.coherence, setup),
            averages=averages.value,
            averages_error=averages.standard_error,
            setup=replace(setup, drives=self._drives(setup), responses=self._responses(setup)),
            force_spectrum=self.force_spectrum,
            response_spectrum=self._shaped(self.response_spectrum, setup),
            force_cross_spectra=self._cross_spectra(setup),
            notes=("imported", *self._missing_data_notes(), *self.notes),
            assumed=(*self.assumed, *assumed),
        )

    def without_log_book(self, declared: DeclaredTest = NOTHING_DECLARED) -> Measurement:
        """Return the measurement without a log book.

        Drive points and responses of its rig are those of the file. The analyser has the lines of the file,
        see `analyser_of`, and unless declared a rectangular window without leakage.

        Raises
        ------
        InvalidInputError
            If the file's arrays do not fit together.
        """
        window = None if declared.window is None else WINDOWS[declared.window]
        averages, assumed = self._averages(declared, None, window)
        roved = len(self.frf.inputs) > 1 and not self.simultaneous
        exciter = declared.exciter or ("hammer" if roved else "shaker")
        analyser, notes = analyser_of(self.frf.freq, averages.value)
        setup = RigSetup(
            drives=self.frf.inputs,
            responses=self.frf.outputs,
            exciter=Exciter(kind=exciter),
            analyser=replace(
                analyser,
                **declared.analyser_window,
                excitation=ExcitationSetting(level=None, shape="unknown"),
            ),
            noise=Noise(None, None),
        )
        return Measurement(
            frf=self.frf,
            coherence=self._shaped(self.coherence, setup),
            averages=averages.value,
            averages_error=averages.standard_error,
            setup=setup,
            force_spectrum=self.force_spectrum,
            response_spectrum=self._shaped(self.response_spectrum, setup),
            force_cross_spectra=self._cross_spectra(setup),
            notes=("imported", NO_LOG_BOOK, *notes, *self._missing_data_notes(), *self.notes),
            assumed=(*self.assumed, *assumed, *declared.assumptions(exciter, averages.correlation)),
        )

    def _averages(
        self, declared: DeclaredTest, in_rig: float | None, window: Window | None
    ) -> tuple[EstimatedAverages, tuple[Assumption, ...]]:
        """Return effective averages, and what is assumed of them and of random errors."""
        known, errors = declared.known_averages(self.averages, in_rig), random_error_of(self, window)
        if known is not None:
            return EstimatedAverages(known), errors
        averages = averages_of(self, window)
        return averages, (*averages.assumed, *errors)

    def _missing_data_notes(self) -> tuple[str, ...]:
        return (NO_COHERENCE,) if self.coherence is None else ()

    def _shaped(self, array: FloatArray | None, setup: RigSetup) -> FloatArray | None:
        """Return an array of each response, or of each FRF where a hammer roved."""
        roved = setup.exciter.kind == "hammer" and len(self.frf.inputs) > 1
        if array is None or array.ndim < 3 or roved or not (array == array[:, :, :1]).all():
            return array
        return array[:, :, 0]

    def _cross_spectra(self, setup: RigSetup) -> ComplexArray | None:
        """Return the cross spectra of simultaneous forces; others have none."""
        return self.force_cross_spectra if setup.n_simultaneous > 1 else None

    def _drives(self, setup: RigSetup) -> tuple[Dof, ...]:
        """Return the drives in the order of the file; a hammer may have left out some of the rig's."""
        declared, measured = set(setup.drives), set(self.frf.inputs)
        if measured != declared and not (setup.exciter.kind == "hammer" and measured < declared):
            raise InvalidInputError(
                "the file drives elsewhere than the rig",
                field="inputs",
                value=list(map(str, self.frf.inputs)),
                allowed=list(map(str, setup.drives)),
            )
        return self.frf.inputs

    def _responses(self, setup: RigSetup) -> tuple[Dof, ...]:
        strange = [str(dof) for dof in self.frf.outputs if dof not in setup.responses]
        if strange:
            raise InvalidInputError(
                "the file holds responses that the rig does not have",
                field="outputs",
                value=list(strange),
                allowed=list(map(str, setup.responses)),
            )
        return self.frf.outputs

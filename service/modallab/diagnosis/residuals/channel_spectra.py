"""Spectra of a measurement by FRF channel, runs and forces side by side."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.partial_coherence import regular_coherence
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.frf_channel import FrfChannel, FrfLayout, force_numbers, frf_channels
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class ChannelSpectra:
    """Spectra of a measurement by FRF channel: run by run, in each force by force all responses."""

    freq: FloatArray
    """(n_freq,) Hz."""
    channels: tuple[FrfChannel, ...]
    """FRFs, n_out of them."""
    h: ComplexArray
    """(n_freq, n_out) FRFs."""
    coherence: FloatArray | None
    """(n_freq, n_out), of several simultaneous forces the partial coherence; None: unknown."""
    response_coherence: FloatArray | None
    """(n_freq, n_out), coherence of each response with all forces of its run; None: unknown."""
    force: FloatArray | None
    """(n_freq, n_force), N^2/Hz, auto spectra of the forces of all runs; None: unknown."""
    response: FloatArray | None
    """(n_freq, n_out), auto spectra of the responses; None: unknown."""
    averages: float
    """Effective number of averages."""
    noise_floor: float | None
    """Relative error of the FRFs as their owner states it."""
    excitation: ExcitationSetting
    """Signal of the source."""
    n_simultaneous: int = 1
    """Forces that act at the same time."""
    forces: ComplexArray | None = None
    """N^2/Hz, (n_freq, n_out, n_in, n_in), cross spectra of these in the run of each FRF; None with one."""
    force_correlation: ComplexArray | None = None
    """(n_run, n_freq, n_in, n_in), these as measured, over their auto spectra; None: not measured."""

    @classmethod
    def of(cls, measurement: Measurement) -> "ChannelSpectra":
        """Return the spectra of a measurement."""
        frf, channels = measurement.frf, frf_channels(measurement.setup)
        forces = measurement.simultaneous_forces
        layout = FrfLayout.of(channels, frf.outputs, frf.inputs)
        coherence, response_coherence, force, response = (
            None if array is None else layout.by_channel(array)
            for array in (
                measurement.frf_coherence,
                measurement.coherence,
                measurement.force_spectrum,
                measurement.response_spectrum,
            )
        )
        _, first_of_force = np.unique(force_numbers(channels), return_index=True)
        return cls(
            freq=frf.freq,
            channels=channels,
            h=layout.by_channel(frf.values),
            coherence=coherence,
            response_coherence=response_coherence,
            force=None if force is None else force[:, first_of_force],
            response=response,
            averages=measurement.averages,
            noise_floor=measurement.noise_floor,
            excitation=measurement.setup.analyser.excitation,
            n_simultaneous=measurement.setup.n_simultaneous,
            forces=None if forces is None else forces[:, list(layout.rows)],
            force_correlation=_force_correlation(measurement),
        )

    @property
    def conditional_averages(self) -> float:
        """Effective number of averages, less the one that each further simultaneous force takes up."""
        return self.averages - (self.n_simultaneous - 1)

    @property
    def force_by_channel(self) -> FloatArray | None:
        """(n_freq, n_out), N^2/Hz, the force of each FRF."""
        return None if self.force is None else self.force[:, force_numbers(self.channels)]


def _force_correlation(measurement: Measurement) -> ComplexArray | None:
    cross = measurement.force_cross_spectra
    if cross is None:
        return None
    outputs = [dof.point for dof in measurement.frf.outputs]
    first = [outputs.index(run.outputs[0].point) for run in measurement.setup.acquisition_runs]
    return regular_coherence(cross[:, first].swapaxes(0, 1))[0]

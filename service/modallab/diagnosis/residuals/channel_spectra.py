"""Spectra of a measurement by FRF channel, the runs side by side."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.frf_channel import FrfChannel, FrfLayout, frf_channels
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class ChannelSpectra:
    """Spectra of a measurement by FRF channel: the responses of the first run, of the second, and so on."""

    freq: FloatArray
    """(n_freq,) Hz."""
    channels: tuple[FrfChannel, ...]
    """FRFs, n_out of them."""
    h: ComplexArray
    """(n_freq, n_out) FRFs."""
    coherence: FloatArray | None
    """(n_freq, n_out); None: unknown."""
    force: FloatArray | None
    """(n_freq, n_run), N^2/Hz, auto spectra of the forces; None: unknown."""
    response: FloatArray | None
    """(n_freq, n_out), auto spectra of the responses; None: unknown."""
    averages: float
    """Effective number of averages."""
    noise_floor: float | None
    """Relative error of the FRFs as their owner states it."""
    excitation: ExcitationSetting
    """Signal of the source."""

    @classmethod
    def of(cls, measurement: Measurement) -> "ChannelSpectra":
        """Return the spectra of a measurement with one force a run."""
        frf, channels = measurement.frf, frf_channels(measurement.setup)
        layout = FrfLayout.of(channels, frf.outputs, frf.inputs)
        arrays = (measurement.coherence, measurement.force_spectrum, measurement.response_spectrum)
        coherence, force, response = (None if array is None else layout.by_channel(array) for array in arrays)
        _, first_of_run = np.unique([channel.run for channel in channels], return_index=True)
        return cls(
            freq=frf.freq,
            channels=channels,
            h=layout.by_channel(frf.values),
            coherence=coherence,
            force=None if force is None else force[:, first_of_run],
            response=response,
            averages=measurement.averages,
            noise_floor=measurement.noise_floor,
            excitation=measurement.setup.analyser.excitation,
        )

    @property
    def force_by_channel(self) -> FloatArray | None:
        """(n_freq, n_out), N^2/Hz, the force of each FRF's run."""
        return None if self.force is None else self.force[:, [channel.run for channel in self.channels]]

"""Quantisation by the converter."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.system import DynamicSystem
from modallab.rig.acquisition import Acquisition, Batch
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("quantisation")
@dataclass(frozen=True)
class Quantisation(Effect):
    """Rounding of every sample to a whole number of steps q of the converter.

    At the place `null` the force channels are rounded, too. A converter of b bits and a full scale of +-R has
    the step q = 2R / 2^b; b is `bits` of the analyser. The expected error is white noise of q^2/12 from 0 Hz
    to half the sample rate, uncorrelated with any signal. Widrow, Kollar and Liu (1996), IEEE Trans.
    Instrumentation and Measurement 45, 353-361: for Gaussian signals of standard deviation s the correlation
    of error and signal is of the order of exp(-2 pi^2 s^2/q^2), 1e-8 at q = s and 1 % at q = 2 s. A signal
    that repeats in every record, such as a sweep without noise, has the same error in every record; averaging
    does not reduce it.
    """

    kind: ClassVar[str] = "quantisation"
    summary: ClassVar[str] = "samples are rounded to the steps of the converter"
    stage: ClassVar[Stage] = Stage.QUANTISATION
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    step: float = parameter(
        0.03,
        unit="1",
        lower=0.0,
        upper=2.0,
        doc="step of the converter over the rms of the channel's signal: 0.031 for 8 bits and a range of 4",
        scan_values=(0.003, 0.03, 0.3),
    )

    def on_spectra(self, spectra: CrossSpectra, acquisition: Acquisition) -> CrossSpectra:
        """Return the spectra with the rounding noise on those of the channels themselves."""
        n_in, n_out = spectra.fx.shape[2:]
        noise_shares = acquisition.analyser.line_window.noise_shares(n_in, n_out)
        noise = self._steps(acquisition)[:, None] ** 2 / (6 * acquisition.sample_rate) * noise_shares
        ff = spectra.ff.copy()
        ff[..., np.arange(n_in), np.arange(n_in)] += noise[..., :n_in]
        return replace(spectra, ff=ff, xx=spectra.xx + noise[..., n_in:])

    def on_records(self, batch: Batch, acquisition: Acquisition, rng: np.random.Generator) -> FloatArray:
        """Return the samples rounded."""
        steps = self._steps(acquisition)[batch.run][:, None]
        rounds = steps > 0
        step_sizes = np.where(rounds, steps, 1.0)
        return np.where(rounds, np.round(batch.samples / step_sizes) * step_sizes, batch.samples)

    def _steps(self, acquisition: Acquisition) -> FloatArray:
        quantised = acquisition.channel_mask(
            lambda channel: self.at is None or (not channel.force and self.acts_on(channel.dof))
        )
        return np.asarray(self.step * acquisition.rms * quantised)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        analyser = setup.analyser
        if analyser.bits is None:
            return []
        return [cls(step=2 * analyser.range_factor / 2**analyser.bits)]

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return all channels and each response; nowhere if their noise, which it is like, is unknown."""
        if setup.noise.force is None or setup.noise.response is None:
            return ()
        return (None, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence is lower than it should be, as with white noise on all channels."""
        drop = float(np.clip(evidence.coherence_drop.mean() / 0.01, 0.0, 1.0))
        return 0.8 * min(1.0, max(drop, evidence.excess, evidence.force_excess))

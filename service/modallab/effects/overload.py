"""Overload: clipping by the converter."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import OVERLOAD
from modallab.estimation.clipping import clipped_spectra
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.system import DynamicSystem
from modallab.rig.acquisition import Acquisition, Batch
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup


@EFFECTS.register("overload")
@dataclass(frozen=True)
class Overload(Effect):
    """Clipping by the converter, x' = min(max(x, -c), c), c = `level` times the rms of the channel.

    At the place `null` the force channels are clipped, too. The route `sampled` clips every sample. The
    expected spectra are those of Gaussian signals: a clipped signal is the signal times erf(level / sqrt 2)
    plus a distortion of known power (Bussgang 1952), whose spectrum comes from the odd powers of the
    correlation up to order 11 (Price 1958). The power of all higher orders is small and is counted as
    order 13. For signals that are not Gaussian (sweeps, bursts, impacts) the expected spectra are a rough
    estimate, and far too small or too large if the peak of a blow is clipped; a diagnosis does not suspect
    the effect in such tests. Distortion is concentrated in few peaks of a record: from level 2 on, the
    coherence of the route `sampled` scatters more than that of the route `drawn`.
    """

    kind: ClassVar[str] = "overload"
    summary: ClassVar[str] = "samples beyond the range of the converter are clipped"
    stage: ClassVar[Stage] = Stage.ACQUISITION
    intermittent: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    level: float = parameter(
        1.5,
        unit="1",
        lower=0.5,
        upper=OVERLOAD.max_level,
        absent=OVERLOAD.max_level,
        doc="range of the converter over the rms of the channel's signal",
        scan_values=(1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0),
    )

    def on_spectra(self, spectra: CrossSpectra, acquisition: Acquisition) -> CrossSpectra:
        """Return the spectra of the clipped signals."""
        levels = self._levels(acquisition)
        return clipped_spectra(spectra, levels, acquisition.noise, acquisition.sample_rate)

    def on_records(self, batch: Batch, acquisition: Acquisition, rng: np.random.Generator) -> FloatArray:
        """Return the samples clipped."""
        level = self._levels(acquisition)[batch.run][:, None]
        return np.clip(batch.samples, -level, level)

    def _levels(self, acquisition: Acquisition) -> FloatArray:
        clipped = acquisition.channel_mask(
            lambda channel: self.at is None or (not channel.force and self.acts_on(channel.dof))
        )
        return np.where(clipped, self.level, np.inf) * acquisition.rms

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        analyser = setup.analyser
        return [cls(level=analyser.range_factor)] if analyser.bits is not None else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        excitation = EXCITATIONS[setup.analyser.excitation.kind]
        if excitation.phases is not None or excitation.transient is not None:
            return ()  # what is expected of signals that are not Gaussian is no evidence
        # A roving accelerometer has one amplifier: its range is that of all responses, not of the force.
        all_responses = (Channels(setup.responses),) if len(setup.responses) > 1 else ()
        return (None, *all_responses, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence is lower than it should be, at antiresonances most, and the signals are too small."""
        drop = float(np.clip(evidence.coherence_drop.mean() / 0.02, 0.0, 1.0))
        low = min(1.0, max(drop, evidence.excess, evidence.force_excess))
        signals = [part.mean() for part in (evidence.force, evidence.response) if part is not None]
        return low * (0.8 if signals and min(signals) < 0 else 0.4)

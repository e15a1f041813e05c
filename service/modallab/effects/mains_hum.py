"""Mains hum on the response channels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import MAINS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.system import DynamicSystem
from modallab.rig.acquisition import Acquisition, Batch, samples_of
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("mains_hum")
@dataclass(frozen=True)
class MainsHum(Effect):
    """Sine of the mains frequency f and its harmonics 2 f, 3 f, 5 f and 7 f.

    By default the 3rd, 5th and 7th harmonics have 1/3, 1/5 and 1/7 of the amplitude, those of a square
    wave, and the 2nd, of a rectifier, is absent. Records are not synchronised with the mains, so that the
    phase is random in every record. In the mean the hum adds nothing to G_fx; to G_xx it adds the power P_k
    of harmonic k times the line shape of the window at its offset, G_xx' = G_xx + sum P_k (W(f - k f_m) +
    W(f + k f_m)) over the line spacing, the limit of 1992 thesis, equation 5.11, for a sine. The anti-alias
    filter removes harmonics above the range.
    """

    kind: ClassVar[str] = "mains_hum"
    summary: ClassVar[str] = "mains frequency and its harmonics on the response signals"
    stage: ClassVar[Stage] = Stage.NOISE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    line_frequencies: ClassVar[tuple[float, ...]] = MAINS.frequencies
    ratio: float = parameter(
        0.01,
        unit="1",
        lower=0.0,
        upper=10.0,
        doc="rms of the fundamental over that of the channel's signal",
        scan_values=(1e-3, 1e-2, 0.1),
    )
    frequency: float = parameter(
        50.0,
        unit="Hz",
        lower=10.0,
        upper=500.0,
        doc="of the mains",
        absent=None,
        scan_values=MAINS.frequencies,
    )
    second_harmonic: float = parameter(
        0.0,
        unit="1",
        lower=0.0,
        upper=5.0,
        doc="amplitude of the 2nd harmonic over that of the fundamental",
        absent=None,
        optional_start=MAINS.harmonic_start,
    )
    third_harmonic: float = parameter(
        1 / 3,
        unit="1",
        lower=0.0,
        upper=5.0,
        doc="amplitude of the 3rd harmonic over that of the fundamental",
        absent=None,
        optional_start=MAINS.harmonic_start,
    )
    higher_harmonics: float = parameter(
        1.0,
        unit="1",
        lower=0.0,
        upper=5.0,
        doc="amplitudes of the 5th and 7th harmonics over 1/5 and 1/7 of that of the fundamental",
        absent=None,
        optional_start=MAINS.harmonic_start,
    )

    def on_spectra(self, spectra: CrossSpectra, acquisition: Acquisition) -> CrossSpectra:
        """Return the spectra with the harmonics' lines in G_xx."""
        spacing, (orders, amplitudes) = acquisition.analyser.spacing, self._harmonics(acquisition)
        place, line = orders * self.frequency / spacing, spectra.freq[:, None] / spacing
        shape, n = acquisition.analyser.line_window.line_shape, samples_of(acquisition.analyser)
        power = (shape(line - place, n) + shape(line + place, n)) @ amplitudes**2 / spacing
        rms = (self.ratio * acquisition.rms * self._hums(acquisition))[:, acquisition.n_in :]
        return replace(spectra, xx=spectra.xx + power[:, None] * rms[:, None, :] ** 2)

    def on_records(self, batch: Batch, acquisition: Acquisition, rng: np.random.Generator) -> FloatArray:
        """Return the samples with the hum added, in phase on all channels of a record."""
        orders, amplitudes = self._harmonics(acquisition)
        n_block, _, n_samples = batch.samples.shape
        start = rng.uniform(0, 2 * np.pi, (n_block, len(MAINS.odd_harmonics)))
        if self.second_harmonic:
            start = np.hstack([start, rng.uniform(0, 2 * np.pi, (n_block, 1))])
        start = start[:, self._inside(acquisition), None]
        turn = 2 * np.pi * self.frequency / acquisition.sample_rate * np.arange(n_samples)
        hum = np.sqrt(2) * (amplitudes @ np.sin(orders[:, None] * turn + start))
        rms = (self.ratio * acquisition.rms * self._hums(acquisition))[batch.run]
        return np.asarray(batch.samples + rms[:, None] * hum[:, None, :])

    @property
    def _orders(self) -> FloatArray:
        return np.array([*MAINS.odd_harmonics, *([2] if self.second_harmonic else [])], float)

    def _inside(self, acquisition: Acquisition) -> BoolArray:
        analyser = acquisition.analyser
        # Up to half a line above the last one: a fit of the frequency must not lose a harmonic in that.
        return np.asarray(self._orders * self.frequency <= analyser.frequency_max + analyser.spacing / 2)

    def _harmonics(self, acquisition: Acquisition) -> tuple[FloatArray, FloatArray]:
        """Return order and amplitude over the fundamental's, (n,) each, of the harmonics in the band."""
        known = {1.0: 1.0, 2.0: self.second_harmonic, 3.0: self.third_harmonic}
        amplitudes = np.array([known.get(order, self.higher_harmonics / order) for order in self._orders])
        inside = self._inside(acquisition)
        return self._orders[inside], amplitudes[inside]

    def _hums(self, acquisition: Acquisition) -> BoolArray:
        return acquisition.channel_mask(lambda channel: not channel.force and self.acts_on(channel.dof))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None, *(Channels((dof,)) for dof in setup.responses))

    def equivalent(self, setup: RigSetup) -> Self | None:
        """Return the hum mirrored about its line: auto spectra can hardly distinguish the two."""
        spacing, bounds = setup.analyser.spacing, self.specs()["frequency"]
        mirror_frequency = 2 * round(self.frequency / spacing) * spacing - self.frequency
        return (
            replace(self, frequency=mirror_frequency)
            if bounds.lower <= mirror_frequency <= bounds.upper
            else None
        )

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence is lower than it should be at the mains frequency, and not in general."""
        drop = np.maximum(evidence.coherence_drop, 0.0).max(axis=1)
        at_mains = max(float(drop[np.abs(evidence.freq - f).argmin()]) for f in MAINS.frequencies)
        return at_mains / (at_mains + 3 * float(drop.mean()) + 1e-12)

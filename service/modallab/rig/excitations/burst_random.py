"""Burst random excitation."""

from collections.abc import Iterator

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.excitation import EXCITATIONS, Excitation, ExcitationSetting
from modallab.rig.impulse_responses import ImpulseResponses
from modallab.rig.record_settings import BURST


class Burst:
    """White noise over the first part of each record, then silence.

    White noise is a sum of impulses at all moments, none of which has anything to do with another: its
    mean spectra are those of single impulses, averaged over the moments of the burst.
    """

    def spectrum(self, omega: FloatArray, setting: ExcitationSetting) -> ComplexArray:
        """Return 1: it is white."""
        return np.ones(len(omega), complex)

    def misaligned(self, setting: ExcitationSetting) -> bool:
        """Return False: exciters are mounted."""
        return False

    def expected_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> Iterator[FloatArray]:
        """Yield the records of single impulses."""
        length, n = self._samples(answers, setting), answers.n_samples
        edges = np.linspace(0, length, min(length, BURST.n_impulses) + 1)
        # One moment of each equal part, at no equal distances: these would take fast beats for slow ones.
        place = (BURST.golden_ratio * np.arange(len(edges) - 1)) % 1.0
        moments = np.floor(edges[:-1] + place * np.diff(edges)).astype(int)
        size = np.sqrt(n * answers.n_in)
        batch = max(1, BURST.record_block // (n * answers.samples.shape[0] * answers.samples.shape[1]))
        for start in range(0, len(moments), batch):
            records = answers.records_after(moments[start : start + batch])
            yield size * records.reshape(-1, *records.shape[2:])

    def random_records(
        self, answers: ImpulseResponses, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return n records, (n, n_ch, n_samples)."""
        length, n_samples = self._samples(answers, setting), answers.n_samples
        source_samples = rng.standard_normal((n, answers.n_in, length)) * np.sqrt(n_samples / length)
        lines = scipy.fft.rfft(source_samples, 2 * n_samples)
        # Time 0 of the answers is in their middle: what wraps around falls on what is cut off.
        answer = scipy.fft.rfft(np.roll(answers.samples, n_samples, axis=-1))
        channel_lines = np.einsum("nsf,scf->ncf", lines, answer)
        return np.asarray(scipy.fft.irfft(channel_lines, 2 * n_samples, overwrite_x=True)[..., :n_samples])

    def basis_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> None:
        """Return None: it is Gaussian."""

    def weights(
        self, n_sources: int, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return an empty array: the signal is random."""
        return np.zeros((n, 0))

    def moments(self, n_sources: int, setting: ExcitationSetting) -> FloatArray:
        """Return an empty array: the signal is random."""
        return np.zeros((0, 0))

    def _samples(self, answers: ImpulseResponses, setting: ExcitationSetting) -> int:
        """Return the length of the burst in samples."""
        return max(1, round(setting.burst * answers.n_samples))


EXCITATIONS.register("burst_random")(
    Excitation(
        summary="random for a share of the record, then silence while the response dies out: leaks little",
        transient=Burst(),
        settings=("level", "burst"),
    )
)

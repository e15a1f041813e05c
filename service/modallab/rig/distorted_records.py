"""What nonlinear forces add to time records: found by steps in time, heard by every channel."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.rig.acquisition import samples_of
from modallab.rig.chain import NEARLY_STILL, Chain
from modallab.rig.distortion import motions
from modallab.rig.stepping import Feedback, Stepper, residual_forces

FINER = 4  # steps per sample of the analyser: third harmonics of half the band, 1 % of the force at its top
FORGOTTEN = 0.05  # share of a residual's effect that may be missing where a record begins
LONGEST = 12  # records of lead-in at most


@dataclass(frozen=True, eq=False)
class Played:
    """What the sources play, line by line: (n, n_in, n_lines), periodic in `n_records` records.

    `share` of the excitation's power is in it. `starts` (n_block,) are the first samples of the records
    cut from it; with n = 1 all are cut from the same stretch, else each from its own.
    """

    lines: ComplexArray
    share: float
    n_records: int
    starts: IntArray


class Distorter:
    """Adds to the records of a run what its nonlinear forces leave of their straight lines."""

    def __init__(self, chain: Chain, run: int) -> None:
        self._analyser = analyser = chain.setup.analyser
        self._run = chain.runs[run]
        self._n = samples_of(analyser)
        self._rate = FINER * self._n * analyser.spacing
        self._lead = self._lead_in()
        self._stepper = Stepper(
            Feedback.of(self._run.whole, tuple(one.force.dof for one in self._run.local)), 1 / self._rate
        )
        # What a channel hears of a newton at a nonlinear force, over lead-in and record together.
        freq = np.arange(self._span // 2 + 1) * analyser.spacing / (1 + self._lead)
        alone = replace(chain, runs=(self._run,))
        self._heard: ComplexArray = np.ascontiguousarray(np.moveaxis(alone.distort(freq).channels[0], 0, -1))

    @property
    def _span(self) -> int:
        """Samples of lead-in and record."""
        return (1 + self._lead) * self._n

    def _lead_in(self) -> int:
        """Return how many records it takes until a start from rest is forgotten."""
        frequencies, widths = self._run.resonances(self._analyser.frequency_max)
        slowest = widths[frequencies < self._analyser.frequency_max].min(initial=np.inf)
        ringing = -np.log(FORGOTTEN) / (2 * np.pi * max(slowest, 1e-12)) * self._analyser.spacing
        return int(np.clip(np.ceil(ringing), 1, LONGEST))

    def added(self, played: Sequence[Played]) -> FloatArray:
        """Return what the channels hear of the residuals in each record, (n_block, n_ch, n_samples)."""
        motion = sum((self._motion(one) for one in played[1:]), self._motion(played[0]))
        n_local = len(self._run.local)
        left = residual_forces(self._run.local, motion[:, :n_local], motion[:, n_local:], self._stepper)
        lines = scipy.fft.rfft(left)[..., : self._heard.shape[-1]] / FINER
        # The residual is a force against the structure's motion: on the structure it acts the other way.
        heard = -np.einsum("crf,nrf->ncf", self._heard, lines, optimize=True)
        return np.asarray(scipy.fft.irfft(heard, self._span)[..., -self._n :])

    def _motion(self, played: Played) -> FloatArray:
        """Return displacement and velocity at the forces, (n_block, 2 r, fine samples), lead-in first."""
        n_lines = played.lines.shape[-1]
        freq = np.linspace(0.0, self._analyser.frequency_max, n_lines)
        whole = played.n_records * self._n * FINER
        omega = 2 * np.pi * np.maximum(freq, NEARLY_STILL * self._analyser.spacing)
        driven, _ = motions(self._run, [one.force for one in self._run.local], omega)
        driven[0] = 0.0  # a free body's place is no part of its vibration
        both = np.concatenate([driven, 1j * omega[:, None, None] * driven], axis=1)
        lines = np.einsum("fmi,nif->nmf", both, played.lines)
        density = played.share * self._analyser.excitation.level**2 / self._analyser.frequency_max
        samples = scipy.fft.irfft(lines, whole) * np.sqrt(density * self._rate * whole / 2)
        window = np.arange(-self._lead * self._n * FINER, self._n * FINER)
        at = (FINER * played.starts[:, None] + window) % whole
        if len(samples) == 1:
            return np.asarray(np.moveaxis(samples[0][:, at], 0, 1))
        return np.asarray(np.take_along_axis(samples, at[:, None, :], axis=2))

"""Time records of nonlinear forces, by time integration of their residuals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.rig.acquisition import samples_of
from modallab.rig.analyser import Analyser
from modallab.rig.chain import Chain
from modallab.rig.distortion import local_receptances
from modallab.rig.nonlinear_settings import NONLINEAR_RECORDS
from modallab.rig.run import Run
from modallab.rig.settings import CHAIN
from modallab.rig.time_stepping import ModalFeedback, Stepper, check_bounded, residual_forces


@dataclass(frozen=True, eq=False)
class SourceSignal:
    """Signals of the sources, each periodic in `n_records` records, and the records cut from them."""

    lines: ComplexArray
    """(k, n_in, n_lines) spectra of k signals."""
    share: float
    """1, share of the power of the excitation."""
    n_records: int
    starts: IntArray
    """(n_block,) first sample of each record."""
    signal_index: IntArray
    """(n_block,) signal of each record."""

    @classmethod
    def joined(cls, parts: "Sequence[SourceSignal]") -> "SourceSignal":
        """Return the records of several signals, concatenated."""
        offsets = np.cumsum([0, *(len(part.lines) for part in parts)])
        return replace(
            parts[0],
            lines=np.concatenate([part.lines for part in parts]),
            starts=np.concatenate([part.starts for part in parts]),
            signal_index=np.concatenate(
                [part.signal_index + offset for part, offset in zip(parts, offsets, strict=False)]
            ),
        )


class Distorter:
    """Adds the response to the residuals of nonlinear forces to the records of some runs.

    Records of all these runs are stepped side by side; each begins as early as its own run asks for.
    """

    def __init__(self, chain: Chain, runs: Sequence[int]) -> None:
        self._analyser = analyser = chain.setup.analyser
        self._runs = [chain.runs[run] for run in runs]
        self._n = samples_of(analyser)
        self._leads = [lead_in_records(run, analyser) for run in self._runs]
        step = 1 / (NONLINEAR_RECORDS.oversampling * self._n * analyser.spacing)
        self._of_velocity = [
            linearised_force.force.of_velocity for linearised_force in self._runs[0].local_forces
        ]
        feedbacks = modal_feedbacks(self._runs)
        self._stepper = Stepper(feedbacks, self._of_velocity, step)
        self._channel_responses = [
            self._channel_response(chain, *pair) for pair in zip(self._runs, self._leads, strict=True)
        ]

    def _channel_response(self, chain: Chain, run: Run, lead: int) -> ComplexArray:
        """Return the channels' response to residual forces, over lead-in and record."""
        freq = np.arange((1 + lead) * self._n // 2 + 1) * self._analyser.spacing / (1 + lead)
        answer = replace(chain, runs=(run,)).residual_response(freq).channels[0]
        return np.ascontiguousarray(np.moveaxis(answer, 0, -1))

    def distortion(self, played: Sequence[Sequence[SourceSignal]]) -> list[FloatArray]:
        """Return the channels' response to the residual forces, (n_block, n_ch, n_samples) of each run.

        Parameters
        ----------
        played
            By run, of as many records each.
        """
        longest = max(self._leads)
        local_receptances = [
            self._motion(*arguments, longest)
            for arguments in zip(self._runs, played, self._leads, strict=True)
        ]
        residuals = residual_forces(
            [run.local_forces for run in self._runs],
            lambda start, end: np.stack([motion(start, end) for motion in local_receptances], axis=1),
            (1 + longest) * self._n * NONLINEAR_RECORDS.oversampling,
            self._stepper,
        )
        return [
            self._channel_records(
                residuals[(longest - lead) * self._n * NONLINEAR_RECORDS.oversampling :, i], channel_response
            )
            for i, (lead, channel_response) in enumerate(
                zip(self._leads, self._channel_responses, strict=True)
            )
        ]

    def _channel_records(self, residuals: FloatArray, channel_response: ComplexArray) -> FloatArray:
        """Return the channels' records of residual forces (n_fine, n, r), lead-in first."""
        lines = (
            scipy.fft.rfft(residuals, axis=0)[: channel_response.shape[-1]] / NONLINEAR_RECORDS.oversampling
        )
        # The residual is a force against the structure's motion: on the structure it acts the other way.
        channel_lines = -np.einsum("crf,fnr->ncf", channel_response, lines, optimize=True)
        return np.asarray(
            scipy.fft.irfft(channel_lines, len(residuals) // NONLINEAR_RECORDS.oversampling)[..., -self._n :]
        )

    def _motion(
        self, run: Run, played: Sequence[SourceSignal], lead: int, longest: int
    ) -> Callable[[int, int], FloatArray]:
        """Return a function from sample range to the motion at the forces (n, n_block, r).

        Nothing moves before a run's own lead-in begins.
        """
        samples = [self._samples(run, signal) for signal in played]
        first_sample = (longest - lead) * self._n * NONLINEAR_RECORDS.oversampling

        def between(start: int, end: int) -> FloatArray:
            time = np.arange(start, end)
            parts = []
            for signal, motion in zip(played, samples, strict=True):
                position = (
                    NONLINEAR_RECORDS.oversampling * signal.starts
                    + (time - longest * self._n * NONLINEAR_RECORDS.oversampling)[:, None]
                )
                position %= len(motion)
                parts.append(motion[position, signal.signal_index])
            total = sum(parts[1:], parts[0])
            if start < first_sample:
                total[time < first_sample] = 0.0
            return np.asarray(total)

        return between

    def _samples(self, run: Run, played: SourceSignal) -> FloatArray:
        """Return the motion at the forces of a run, (n_samples, n, r), over one period of the source."""
        n_lines = played.lines.shape[-1]
        freq = np.linspace(0.0, self._analyser.frequency_max, n_lines)
        n_period = played.n_records * self._n * NONLINEAR_RECORDS.oversampling
        omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * self._analyser.spacing)
        driven = local_receptances(
            [run], [linearised_force.force for linearised_force in run.local_forces], omega
        )[0][0]
        driven[0] = 0.0  # a free body's place is no part of its vibration
        driven = driven * np.where(self._of_velocity, 1j * omega[:, None], 1.0)[..., None]
        lines = np.einsum("fri,nif->fnr", driven, played.lines)
        density = played.share * self._analyser.source_density(freq)
        rate = NONLINEAR_RECORDS.oversampling * self._n * self._analyser.spacing
        lines *= np.sqrt(density * rate * n_period / 2)[:, None, None]
        return np.asarray(scipy.fft.irfft(lines, n_period, axis=0))


def modal_feedbacks(runs: Sequence[Run]) -> list[ModalFeedback]:
    """Return the modal model of each run's structure at its nonlinear forces.

    Raises
    ------
    DivergedError
        If time integration is known not to follow these forces.
    """
    feedbacks = [
        ModalFeedback.of(
            run.with_exciters, tuple(linearised_force.force.dof for linearised_force in run.local_forces)
        )
        for run in runs
    ]
    for run, feedback in zip(runs, feedbacks, strict=True):
        check_bounded(feedback, run.local_forces)
    return feedbacks


def lead_in_records(run: Run, analyser: Analyser) -> int:
    """Return the number of records of the lead-in, after which the initial transient has decayed."""
    frequencies, widths = run.resonances(analyser.frequency_max)
    slowest = widths[frequencies < analyser.frequency_max].min(initial=np.inf)
    decay_records = (
        -np.log(NONLINEAR_RECORDS.decay_threshold)
        / (2 * np.pi * max(slowest, NONLINEAR_RECORDS.min_half_width))
        * analyser.spacing
    )
    return int(np.clip(np.ceil(decay_records), 1, NONLINEAR_RECORDS.max_lead_in))


def max_parallel_records(chain: Chain) -> int:
    """Return the number of records that are integrated in parallel."""
    longest = 1 + max(lead_in_records(run, chain.setup.analyser) for run in chain.runs)
    return max(
        1,
        NONLINEAR_RECORDS.parallel_samples
        // (NONLINEAR_RECORDS.oversampling * samples_of(chain.setup.analyser) * longest),
    )

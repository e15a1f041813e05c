"""Simulated time records of all channels, in batches: memory does not grow with the averages."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import sliding_window_view

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.rig.acquisition import Batch, sample_rate_of, samples_of
from modallab.rig.analyser import Analyser
from modallab.rig.chain import Chain
from modallab.rig.free_decay import impulse_responses_of, transient_of
from modallab.rig.impulse_responses import ImpulseResponses
from modallab.rig.nonlinear_records import Distorter, SourceSignal, max_parallel_records
from modallab.rig.periodic import fixed_lines
from modallab.rig.record_settings import RECORDS

Draft = tuple[Batch, list[SourceSignal]]  # records without nonlinear forces, and their source signals


class Recorder:
    """Generator of the analyser's input, run by run: force channels first.

    Hysteretic damping has no causal form in time, so signals are synthesised in the frequency domain. A
    signal that repeats with the record needs one record. A stationary signal needs a stretch of many
    records with so many lines that it repeats only after every mode has decayed; a part of the stretch as
    long as this decay is discarded.
    """

    def __init__(self, chain: Chain) -> None:
        analyser, share = chain.setup.analyser, chain.source.continuous
        self._chain = chain
        self.n_samples, self.sample_rate = samples_of(analyser), sample_rate_of(analyser)
        self._averages = analyser.simulated_averages
        self._hop = max(1, round(self.n_samples * (1 - chain.overlap)))
        n_ch = chain.n_in + len(chain.runs[0].responses)
        self.shape = (n_ch, self.n_samples)
        self._batch = max(1, RECORDS.record_block // (n_ch * self.n_samples))
        self._per_stretch = min(self._averages, max(1, RECORDS.noise_block // (n_ch * self.n_samples)))
        self._repeats = self._per_stretch
        self._repeating = self._stationary = None
        if share > 0:
            decay_records = _decay_time(chain) / analyser.record_length
            max_records = RECORDS.max_samples / (n_ch * self.n_samples)
            _check_decay(decay_records, max_records, analyser)
            self._repeats = self._plan_stretches(
                min(max(RECORDS.records_per_stretch, decay_records), max_records - decay_records),
                decay_records,
            )
            freq = np.linspace(0.0, analyser.frequency_max, (analyser.n_lines - 1) * self._repeats + 1)
            self._length = self._repeats * self.n_samples
            self._stationary = _source_lines(chain, freq, share * self._length)
            self._stationary[..., -1] *= np.sqrt(0.5)  # half of the last fine line lies beyond the band
        self._transient, self._fixed = transient_of(chain), fixed_lines(analyser)
        if self._transient is not None and chain.runs[0].local_forces:
            raise InvalidInputError(
                "nonlinear forces are not stepped through signals that end within a record",
                field="excitation.kind",
                value=analyser.excitation.kind,
                allowed="an excitation that goes on, or the route expected",
            )
        if chain.runs[0].local_forces:
            self._batch = max(1, min(self._per_stretch, max_parallel_records(chain)))
        if share < 1 and self._transient is None:
            self._repeating = _source_lines(chain, analyser.freq, (1 - share) * self.n_samples)

    @property
    def stretch_layout(self) -> tuple[int, int]:
        """Number of records in a stretch, and its length in records."""
        return self._per_stretch, self._repeats

    def _plan_stretches(self, records: float, decay_records: float) -> int:
        """Divide the averages into equal stretches of about `records`; return the length of one."""
        steps = max(0, int((records - 1) * self.n_samples / self._hop))
        n_stretches = -(-self._averages // (steps + 1))
        self._per_stretch = -(-self._averages // n_stretches)
        span = 1 + (self._per_stretch - 1) * self._hop / self.n_samples
        return int(scipy.fft.next_fast_len(int(np.ceil(span + decay_records)), real=True))

    def batches(self, noise: FloatArray, rng: np.random.Generator) -> Iterator[Batch]:
        """Yield batches of records, one run after the other.

        Parameters
        ----------
        noise
            (n_run, n_ch) one-sided densities of the white noise of each channel, unit^2/Hz.
        """
        runs = range(len(self._chain.runs))
        if not self._chain.runs[0].local_forces:
            for run in runs:
                for batch, _ in self._drafts(run, noise[run], rng):
                    yield batch
            return
        max_pending = min(
            max_parallel_records(self._chain), RECORDS.parallel_samples // (self.shape[0] * self.shape[1])
        )
        runs_per_group = max(1, max_pending // self._averages)
        for first in runs[::runs_per_group]:
            group = runs[first : first + runs_per_group]
            distorter = Distorter(self._chain, group)
            drafts = [self._drafts(run, noise[run], rng) for run in group]
            if len(group) > 1:  # drawn run by run, stepped side by side
                yield from _with_distortion(distorter, [list(run_drafts) for run_drafts in drafts])
                continue
            pending: list[Draft] = []  # what one run has may already be too much at once
            for draft in drafts[0]:
                if pending and sum(len(batch.samples) for batch, _ in (*pending, draft)) > max_pending:
                    yield from _with_distortion(distorter, [pending])
                    pending = []
                pending.append(draft)
            yield from _with_distortion(distorter, [pending])

    def _drafts(self, run: int, noise: FloatArray, rng: np.random.Generator) -> Iterator[Draft]:
        """Yield the records of a run without nonlinear forces, and their source signals."""
        rms = np.sqrt(noise * self.sample_rate / 2)
        answers = None if self._transient is None else impulse_responses_of(self._chain, run)
        n_recorded = 0
        while n_recorded < self._averages:
            n = min(self._per_stretch, self._averages - n_recorded)
            records, source_lines = self._stretch_of(run, rms, rng)
            for start in range(0, n, self._batch):
                block = slice(start, min(start + self._batch, n))
                first = self._hop * np.arange(block.start, block.stop)
                samples, lines = self._fresh_records(run, block.stop - block.start, answers, rng)
                # in place: what is made anew for every record is nobody else's
                batch = records[block] if samples is None else np.add(samples, records[block], out=samples)
                yield (
                    Batch(run, n_recorded * self.n_samples + first, batch),
                    self._source_signals(source_lines, lines, first),
                )
                del samples, batch  # or two of them would be there at a time
            del records
            n_recorded += n

    def _stretch_of(
        self, run: int, rms: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, ComplexArray | None]:
        """Return noise and stationary signals of one stretch as records, and the source lines."""
        span = self.n_samples + (self._per_stretch - 1) * self._hop
        samples = rng.standard_normal((len(rms), span))
        samples *= rms[:, None]
        source_lines = None
        if self._stationary is not None:
            source_lines = self._random_lines(self._stationary[run], 1, rng)
            samples += self._channel_records(self._stationary[run], source_lines, self._length)[0, :, :span]
        records = sliding_window_view(samples, self.n_samples, axis=1)[:, :: self._hop]
        return records.swapaxes(0, 1), source_lines

    def _fresh_records(
        self, run: int, n: int, answers: ImpulseResponses | None, rng: np.random.Generator
    ) -> tuple[FloatArray | None, ComplexArray | None]:
        """Return the periodic or transient part of n records, (n, n_ch, n_samples), and its source lines."""
        samples, lines = None, None
        if self._repeating is not None:
            lines = self._periodic_lines(self._repeating[run], n, rng)
            samples = self._channel_records(self._repeating[run], lines, self.n_samples)
            if len(samples) < n:
                samples = np.repeat(samples, n, axis=0)
        if self._transient is not None and answers is not None:
            setting, share = self._chain.setup.analyser.excitation, self._chain.source.continuous
            blow = np.sqrt(1 - share) * self._transient.random_records(answers, setting, n, rng)
            samples = blow if samples is None else samples + blow
        return samples, lines

    def _source_signals(
        self, stationary_lines: ComplexArray | None, lines: ComplexArray | None, starts: IntArray
    ) -> list[SourceSignal]:
        """Return the source signals of some records: stationary and periodic part."""
        share = self._chain.source.continuous
        first = np.zeros_like(starts)
        signals = (
            []
            if stationary_lines is None
            else [SourceSignal(stationary_lines, share, self._repeats, starts, first)]
        )
        signal_index = first if lines is None or len(lines) == 1 else np.arange(len(starts))
        fresh_signals = [] if lines is None else [SourceSignal(lines, 1 - share, 1, first, signal_index)]
        return [*signals, *fresh_signals]

    def _periodic_lines(self, response: ComplexArray, n: int, rng: np.random.Generator) -> ComplexArray:
        """Return the source lines of n periodic records; (1, 1, n_lines) if all are alike."""
        return self._random_lines(response, n, rng) if self._fixed is None else self._fixed[None, None]

    @staticmethod
    def _random_lines(response: ComplexArray, n: int, rng: np.random.Generator) -> ComplexArray:
        """Return n draws of Gaussian source lines of unit density, (n, n_in, n_lines)."""
        n_in, _, n_lines = response.shape
        lines = rng.standard_normal((n, n_in, 2 * n_lines)).view(complex)
        lines *= np.sqrt(0.5)
        lines[..., 0] = np.sqrt(2) * lines[..., 0].real
        return np.asarray(lines)

    def _channel_records(self, response: ComplexArray, lines: ComplexArray, n_samples: int) -> FloatArray:
        """Return the channels' records (n, n_ch, n_samples), periodic in their length.

        `response` (n_in, n_ch, n_lines) are the channels' lines for sources of unit density.
        """
        n_in, n_ch, n_lines = response.shape
        # As many lines as the transform asks for: it would copy fewer to fill them up.
        channel_lines = np.zeros((len(lines), n_ch, n_samples // 2 + 1), complex)
        first = channel_lines[..., :n_lines]
        np.multiply(lines[:, :1], response[0], out=first)
        for source in range(1, n_in):
            first += lines[:, source : source + 1] * response[source]
        return np.asarray(scipy.fft.irfft(channel_lines, n_samples, overwrite_x=True))


def _with_distortion(distorter: Distorter, drafts: Sequence[Sequence[Draft]]) -> Iterator[Batch]:
    """Yield the records of some runs with the response to nonlinear forces."""
    played = [
        [SourceSignal.joined(parts) for parts in zip(*(signals for _, signals in run_drafts), strict=True)]
        for run_drafts in drafts
    ]
    for run_drafts, added in zip(drafts, distorter.distortion(played), strict=True):
        edges = np.cumsum([len(batch.samples) for batch, _ in run_drafts])[:-1]
        for (batch, _), more in zip(run_drafts, np.split(added, edges), strict=True):
            yield replace(batch, samples=batch.samples + more)


def _check_decay(decay_records: float, max_records: float, analyser: Analyser) -> None:
    """Raise `InvalidInputError` if a mode decays too slowly, in records, for stationary signals."""
    if decay_records > max_records / 2:
        raise InvalidInputError(
            f"a mode rings for {decay_records:.3g} records: too long to simulate stationary ones",
            field="excitation.kind",
            value=analyser.excitation.kind,
            allowed="a periodic excitation, or more damping",
        )


def _decay_time(chain: Chain) -> float:
    """Return the decay time, s, of the least damped mode in the band."""
    frequencies, widths = chain.poles()
    analyser = chain.setup.analyser
    slowest = widths[frequencies < analyser.frequency_max + analyser.spacing].min(initial=np.inf)
    return float(-np.log(RECORDS.decay_threshold) / (2 * np.pi * slowest)) if slowest > 0 else np.inf


def _source_lines(chain: Chain, freq: FloatArray, samples: float) -> ComplexArray:
    """Return the channels' lines per source, (n_run, n_in, n_ch, n_freq), scaled as a discrete transform.

    Parameters
    ----------
    samples
        That it is taken of, times the share of the power.
    """
    analyser, n_in = chain.setup.analyser, chain.n_in
    density = analyser.source_density(freq)
    size = np.sqrt(density * sample_rate_of(analyser) * samples / 2)
    answer = chain.respond(freq)
    n_run, n_freq, n_out, _ = answer.response.shape
    out = np.empty((n_run, n_in, n_in + n_out, n_freq), complex)
    for part, place in ((answer.force, slice(n_in)), (answer.response, slice(n_in, None))):
        np.multiply(part.transpose(0, 3, 2, 1), size, out=out[:, :, place])
    return out

"""Impulse responses of the channels, and spectra of transient excitation."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.averaging import Averager
from modallab.rig.acquisition import sample_rate_of, samples_of
from modallab.rig.chain import Chain
from modallab.rig.excitation import EXCITATIONS, Transient
from modallab.rig.hammer_misalignment import misalignment_responses
from modallab.rig.impulse_responses import ImpulseResponses
from modallab.rig.settings import CHAIN, FREE_DECAY


def transient_of(chain: Chain) -> Transient | None:
    """Return the transient signal of the declared excitation; None if it is steady."""
    return EXCITATIONS[chain.setup.analyser.excitation.kind].transient


def impulse_responses_of(chain: Chain, run: int) -> ImpulseResponses:
    """Return the impulse responses of one run's channels to its sources.

    Found by frequency, on a grid so fine that they have rung out before they repeat. Hysteretic damping is
    slightly non-causal: what comes before the impulse is kept too. The anti-alias filter is flat to
    the top of the band and rolls off as a raised cosine to half the sample rate.

    Raises
    ------
    InvalidInputError
        If a mode rings too long.
    """
    return _impulse_responses(replace(chain, runs=(chain.runs[run],)), FREE_DECAY.decay_threshold)[0]


def all_impulse_responses(
    chain: Chain, forgotten: float = FREE_DECAY.decay_threshold
) -> Iterator[ImpulseResponses]:
    """Yield the impulse responses of every run; runs that fit into memory share a solution."""
    n_fft = samples_of(chain.setup.analyser) * _repeats(replace(chain, runs=chain.runs[:1]), forgotten)
    n_ch = chain.n_in + len(chain.runs[0].responses)
    runs_per_group = max(1, FREE_DECAY.solution_block // (n_fft * n_ch))
    for first in range(0, len(chain.runs), runs_per_group):
        yield from _impulse_responses(
            replace(chain, runs=chain.runs[first : first + runs_per_group]), forgotten
        )


def _impulse_responses(group: Chain, forgotten: float) -> list[ImpulseResponses]:
    analyser, transient = group.setup.analyser, transient_of(group)
    assert transient is not None  # asked for by transient excitations only
    n, rate, setting = samples_of(analyser), sample_rate_of(analyser), analyser.excitation
    n_fft = n * _repeats(group, forgotten)
    freq = scipy.fft.rfftfreq(n_fft, 1 / rate)
    source_spectrum = _source_spectrum(group, freq)
    responses = []
    for run, channel_response in zip(group.runs, group.respond(freq).channels, strict=True):
        if transient.misaligned(setting):
            channel_response = np.concatenate(
                [channel_response, misalignment_responses(replace(group, runs=(run,)), freq)], axis=2
            )
        samples = scipy.fft.irfft(source_spectrum * channel_response.transpose(2, 1, 0), n_fft)
        responses.append(
            ImpulseResponses(np.concatenate([samples[..., -n:], samples[..., :n]], axis=-1), group.n_in)
        )
    return responses


def _source_spectrum(chain: Chain, freq: FloatArray) -> ComplexArray:
    """Return the transform of the source's sampled signal behind the anti-alias filter, (n_freq,) N."""
    analyser, transient = chain.setup.analyser, transient_of(chain)
    assert transient is not None
    rate = sample_rate_of(analyser)
    omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * analyser.spacing)
    spectrum = transient.spectrum(omega, analyser.excitation)
    spectrum = spectrum * _anti_alias(freq, analyser.frequency_max, rate / 2)
    for shaping in chain.source.shaping:
        spectrum = spectrum * shaping(omega)
    return np.asarray(spectrum * np.sqrt(analyser.source_level**2 / analyser.frequency_max * rate / 2))


def decayed_lines(chain: Chain, lines: IntArray | slice) -> ComplexArray | None:
    """Return the lines (n_run, n_lines, n_ch) of one blow at some lines, as if decayed.

    Square roots of one-sided densities. What rings on beyond the record is counted as if it were within:
    for screening, where the error cancels in the ratio of two predictions.

    None where a record is no single blow, or is shortened by its window.
    """
    analyser, transient = chain.setup.analyser, transient_of(chain)
    single = EXCITATIONS[analyser.excitation.kind].deterministic_transient
    assert transient is not None
    if not single or transient.misaligned(analyser.excitation) or analyser.line_window.end < 1:
        return None
    freq = analyser.freq[lines]
    density = 2 / (sample_rate_of(analyser) * analyser.line_window.power)
    spectrum = np.sqrt(density) * _source_spectrum(chain, freq)
    return np.asarray(spectrum[:, None] * chain.respond(freq).channels[..., 0])


def transient_spectra(chain: Chain, forgotten: float = FREE_DECAY.decay_threshold) -> ComplexArray:
    """Return the expected G_ff, G_fx and G_xx side by side, (n_run, n_lines, n_in^2 + n_in n_out + n_out).

    Parameters
    ----------
    forgotten
        Remaining share of an impulse response at which it counts as decayed.
    """
    analyser, transient = chain.setup.analyser, transient_of(chain)
    assert transient is not None
    runs = []
    for answers in all_impulse_responses(chain, forgotten):
        shape = answers.samples.shape[1], answers.n_samples
        averager = Averager(
            analyser.line_window,
            shape,
            sample_rate_of(analyser),
            n_lines=analyser.n_lines,
            n_in=chain.n_in,
        )
        for records in transient.expected_records(answers, analyser.excitation):
            averager.add(records)
        flat = [part.reshape(analyser.n_lines, -1) for part in averager.densities()]
        runs.append(np.concatenate(flat, axis=1))
    return np.array(runs)


def _anti_alias(freq: FloatArray, top: float, nyquist: float) -> FloatArray:
    place = np.clip((freq - top) / (nyquist - top), 0.0, 1.0)
    return np.asarray(np.cos(np.pi / 2 * place) ** 2)


def _repeats(group: Chain, forgotten: float) -> int:
    """Return the length, in records, of the transform of impulse responses: an even number."""
    analyser = group.setup.analyser
    frequencies, widths = group.poles()
    slowest = widths[frequencies < analyser.frequency_max + analyser.spacing].min(initial=np.inf)
    decay_records = -np.log(forgotten) / (2 * np.pi * slowest) * analyser.spacing if slowest > 0 else np.inf
    max_records = FREE_DECAY.max_samples / ((1 + len(group.runs[0].responses)) * samples_of(analyser))
    if decay_records > max_records:
        raise InvalidInputError(
            f"a mode rings for {decay_records:.3g} records: too long to follow what a transient leaves",
            field="excitation.kind",
            value=analyser.excitation.kind,
            allowed="a periodic excitation, or more damping",
        )
    return 2 * int(np.ceil(max(decay_records, 2.0) / 2 + 0.5))

"""Impulse responses of the channels, and spectra of transient excitation."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, cast

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.estimation.averaging import Averager
from modallab.rig.acquisition import sample_rate_of, samples_of
from modallab.rig.chain import Chain
from modallab.rig.excitation import EXCITATIONS, Transient
from modallab.rig.hammer_misalignment import misalignment_responses
from modallab.rig.impulse_responses import ImpulseResponses
from modallab.rig.record_settings import FREE_DECAY
from modallab.rig.ringing_modes import RingingModes, ringing_modes
from modallab.rig.settings import CHAIN


def transient_of(chain: Chain) -> Transient | None:
    """Return the transient signal of the declared excitation; None if it is steady."""
    return EXCITATIONS[chain.setup.analyser.excitation.kind].transient


def impulse_responses_of(chain: Chain, run: int) -> ImpulseResponses:
    """Return the impulse responses of one run's channels to its sources.

    Found by frequency, twice as fine as the lines; what modes leave after that is taken off in closed form.
    Hysteretic damping is slightly non-causal: what comes before the impulse is kept too. The anti-alias
    filter is flat to the top of the band and rolls off as a raised cosine to half the sample rate.
    """
    return _impulse_responses(replace(chain, runs=(chain.runs[run],)))[0]


def all_impulse_responses(chain: Chain) -> Iterator[ImpulseResponses]:
    """Yield the impulse responses of every run; runs that fit into memory share a solution."""
    n_ch = chain.n_in + len(chain.runs[0].responses)
    runs_per_group = max(1, FREE_DECAY.solution_block // (2 * samples_of(chain.setup.analyser) * n_ch))
    for first in range(0, len(chain.runs), runs_per_group):
        yield from _impulse_responses(replace(chain, runs=chain.runs[first : first + runs_per_group]))


def _impulse_responses(group: Chain) -> list[ImpulseResponses]:
    n, rate = samples_of(group.setup.analyser), sample_rate_of(group.setup.analyser)
    spectra = _spectra(group, scipy.fft.rfftfreq(2 * n, 1 / rate))
    samples = scipy.fft.fftshift(scipy.fft.irfft(spectra, 2 * n, axis=1), axes=1)
    for runs, modes in _ringing_modes(group):
        samples[runs] -= _of_runs(modes.aliases(2 * n), samples[runs].shape)
    return [ImpulseResponses(np.ascontiguousarray(run.transpose(2, 1, 0)), group.n_in) for run in samples]


def _of_runs(signals: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Return signals (n, n_run * ...) of runs side by side as (n_run, n, ...)."""
    return signals.reshape(len(signals), shape[0], *shape[2:]).swapaxes(0, 1)


def _spectra(group: Chain, freq: FloatArray) -> ComplexArray:
    """Return the spectra (n_run, n_freq, n_ch, n_sources) of the channels' responses to the source's signal.

    The forces of misaligned blows follow the declared sources.
    """
    analyser, transient = group.setup.analyser, transient_of(group)
    assert transient is not None  # asked for by transient excitations only
    responses = group.respond(freq).channels
    if transient.misaligned(analyser.excitation):
        beside = [misalignment_responses(replace(group, runs=(run,)), freq) for run in group.runs]
        responses = np.concatenate([responses, np.array(beside)], axis=3)
    return np.asarray(_source_spectrum(group, freq)[:, None, None] * responses)


def _ringing_modes(chain: Chain) -> Iterator[tuple[IntArray, RingingModes]]:
    """Yield the indices (m,) of runs of equal resonances, and what rings on beyond their records.

    Signals are those of runs times channels times sources.
    """
    analyser = chain.setup.analyser
    spacing = analyser.spacing
    frequencies, widths = (part / spacing for part in chain.poles())
    _, first, index = np.unique(
        np.hstack([frequencies, widths]), axis=0, return_index=True, return_inverse=True
    )
    for number, run in enumerate(first):  # runs of a roving hammer share them
        members = np.flatnonzero(index == number)
        part = replace(chain, runs=tuple(chain.runs[i] for i in members))

        def spectra(lines: FloatArray, part: Chain = part) -> ComplexArray:
            return np.asarray(_spectra(part, lines * spacing).swapaxes(0, 1).reshape(len(lines), -1))

        yield members, ringing_modes(spectra, frequencies[run], widths[run], samples_of(analyser))


def blow_lines(chain: Chain) -> ComplexArray | None:
    """Return the windowed lines (n_run, n_lines, n_ch) of one blow; None where a record is no single blow.

    Square roots of one-sided densities. Exactly the lines of a record: those of the endless response less
    what it has after the record.
    """
    analyser, transient = chain.setup.analyser, transient_of(chain)
    single = EXCITATIONS[analyser.excitation.kind].deterministic_transient
    if transient is None or not single or transient.misaligned(analyser.excitation):
        return None
    window, n = analyser.line_window, samples_of(analyser)
    n_beside = len(window.coefficients) - 1
    n_lines = n // 2 + 1 if window.transient else analyser.n_lines + n_beside
    before = round(analyser.excitation.pre_trigger * n)
    lines = np.arange(n_lines, dtype=float)
    spectra = _spectra(chain, lines * analyser.spacing)[..., 0]
    for runs, modes in _ringing_modes(chain):
        spectra[runs] -= _of_runs(modes.lines_after(n - before, n_lines, n), spectra[runs].shape)
    spectra *= (np.sqrt(2 / sample_rate_of(analyser)) * np.exp(-2j * np.pi * lines * before / n))[:, None]
    if not window.transient:
        return window.lines(spectra)[:, : analyser.n_lines]
    weights = window.weights(n, chain.n_in, spectra.shape[2] - chain.n_in).T / np.sqrt(window.power)
    records = scipy.fft.irfft(spectra, n, axis=1) * weights
    return np.asarray(scipy.fft.rfft(records, axis=1)[:, : analyser.n_lines])


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
    for screening, where the error cancels in the ratio of two predictions. An exponential window is more
    decay of all that is recorded: responses at omega - i s, of which those of structure and channels are
    analytic functions.

    None where a record is no single blow, or a response is a table by frequency.
    """
    analyser, transient = chain.setup.analyser, transient_of(chain)
    single = EXCITATIONS[analyser.excitation.kind].deterministic_transient
    assert transient is not None
    if not single or transient.misaligned(analyser.excitation):
        return None
    window, freq = analyser.line_window, analyser.freq[lines]
    spectrum = np.sqrt(2 / (sample_rate_of(analyser) * window.power)) * _source_spectrum(chain, freq)
    if window.end < 1:
        if any(effect.tabulated for effect in chain.effects):
            return None
        decay = np.log(window.end) * analyser.spacing
        freq = cast(FloatArray, freq + 1j * decay / (2 * np.pi))
        spectrum = spectrum * window.end**analyser.excitation.pre_trigger
    return np.asarray(spectrum[:, None] * chain.respond(freq).channels[..., 0])


def has_decayed(chain: Chain, remaining: float) -> bool:
    """Return whether blows on a linear structure leave no more than a share of their response at the end.

    Parameters
    ----------
    remaining
        The share, window included.
    """
    if transient_of(chain) is None or chain.runs[0].local_forces:
        return False
    analyser = chain.setup.analyser
    _, widths = chain.poles()
    return bool(analyser.line_window.end * np.exp(-2 * np.pi * widths.min() / analyser.spacing) < remaining)


def transient_spectra(chain: Chain) -> ComplexArray:
    """Return the expected G_ff, G_fx and G_xx side by side, (n_run, n_lines, n_in^2 + n_in n_out + n_out)."""
    analyser, transient = chain.setup.analyser, transient_of(chain)
    assert transient is not None
    runs = []
    if (lines := blow_lines(chain)) is not None:
        return products(lines)
    for answers in all_impulse_responses(chain):
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


def products(lines: ComplexArray) -> ComplexArray:
    """Return G_ff, G_fx and G_xx side by side of the lines (n_run, n_lines, 1 + n_out) of one source."""
    force, response = lines[..., :1], lines[..., 1:]
    return np.concatenate([np.abs(force) ** 2, force.conj() * response, np.abs(response) ** 2], axis=2)


def _anti_alias(freq: FloatArray, top: float, nyquist: float) -> FloatArray:
    place = np.clip((freq - top) / (nyquist - top), 0.0, 1.0)
    return np.asarray(np.cos(np.pi / 2 * place) ** 2)

"""Impulse responses of a run's channels, and what transient signals make of them."""

from dataclasses import replace

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.averaging import Averager
from modallab.rig.acquisition import sample_rate_of, samples_of
from modallab.rig.chain import NEARLY_STILL, Chain
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.strays import stray_responses
from modallab.rig.transient import Answers, Transient

FORGOTTEN = 1e-6  # amplitude below which a mode has rung out
LONGEST = 2**26  # samples of all channels, 0.5 GB


def transient_of(chain: Chain) -> Transient | None:
    """Return what of the declared excitation begins and ends within a record."""
    return EXCITATIONS[chain.setup.analyser.excitation.kind].transient


def answers_of(chain: Chain, run: int) -> Answers:
    """Return the impulse responses of a run's channels to its sources.

    Found by frequency, on a grid so fine that they have rung out before they repeat. Hysteretic damping is
    slightly non-causal: what comes before the impulse is kept too. The anti-alias filter is flat to
    the top of the band and rolls off as a raised cosine to half the sample rate.

    Raises
    ------
    InvalidInputError
        If a mode rings too long.
    """
    alone = replace(chain, runs=(chain.runs[run],))
    analyser = chain.setup.analyser
    n, rate = samples_of(analyser), sample_rate_of(analyser)
    whole = n * _repeats(alone, n)
    freq = scipy.fft.rfftfreq(whole, 1 / rate)
    setting, transient = analyser.excitation, transient_of(chain)
    assert transient is not None  # asked for by transient excitations only
    omega = 2 * np.pi * np.maximum(freq, NEARLY_STILL * analyser.spacing)
    played = transient.spectrum(omega, setting) * _anti_alias(freq, analyser.frequency_max, rate / 2)
    for shaping in chain.source.shaping:
        played = played * shaping(omega)
    heard = alone.respond(freq).channels[0]
    if transient.strays(setting):
        heard = np.concatenate([heard, stray_responses(alone, freq)], axis=2)
    density = setting.level**2 / analyser.frequency_max
    lines = np.sqrt(density * rate / 2) * played * heard.transpose(2, 1, 0)
    samples = scipy.fft.irfft(lines, whole)
    return Answers(np.concatenate([samples[..., -n:], samples[..., :n]], axis=-1), chain.n_in)


def transient_spectra(chain: Chain) -> ComplexArray:
    """Return the expected G_ff, G_fx and G_xx side by side, (n_run, n_lines, n_in^2 + n_in n_out + n_out)."""
    analyser, transient = chain.setup.analyser, transient_of(chain)
    assert transient is not None
    runs = []
    for run in range(len(chain.runs)):
        answers = answers_of(chain, run)
        shape = answers.samples.shape[1], answers.n_samples
        averager = Averager(
            analyser.line_window,
            shape,
            sample_rate_of(analyser),
            n_lines=analyser.n_lines,
            n_in=chain.n_in,
        )
        for records in transient.typical(answers, analyser.excitation):
            averager.add(records)
        flat = [part.reshape(analyser.n_lines, -1) for part in averager.densities()]
        runs.append(np.concatenate(flat, axis=1))
    return np.array(runs)


def _anti_alias(freq: FloatArray, top: float, nyquist: float) -> FloatArray:
    place = np.clip((freq - top) / (nyquist - top), 0.0, 1.0)
    return np.asarray(np.cos(np.pi / 2 * place) ** 2)


def _repeats(alone: Chain, n_samples: int) -> int:
    """Return over how many records the impulse responses are found: an even number."""
    analyser = alone.setup.analyser
    frequencies, widths = alone.poles()
    slowest = widths[frequencies < analyser.frequency_max + analyser.spacing].min(initial=np.inf)
    ringing = -np.log(FORGOTTEN) / (2 * np.pi * slowest) * analyser.spacing if slowest > 0 else np.inf
    room = LONGEST / ((1 + len(alone.runs[0].responses)) * n_samples)
    if ringing > room:
        raise InvalidInputError(
            f"a mode rings for {ringing:.3g} records: too long to follow what a transient leaves",
            field="excitation.kind",
            value=analyser.excitation.kind,
            allowed="a periodic excitation, or more damping",
        )
    return 2 * int(np.ceil(max(ringing, 2.0) / 2 + 0.5))

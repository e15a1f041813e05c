"""Records of a test, and FRFs with coherence from them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.laboratory.bars import Bars, Complexes, Reals, Y
from benchmarks.laboratory.effects import Effect, translations
from benchmarks.laboratory.plan import WINDOW_END, Plan, Run

LONG = 4  # records that the spectrum of a blow covers
FADED = 1e-8  # what is left of a response when that spectrum repeats itself
PULSE = 0.8  # half of a blow's duration times the largest frequency: little is left at half the sampling rate


@dataclass(frozen=True, eq=False)
class Measured:
    """FRFs and coherence of a test as they are handed over."""

    freq: Reals
    """(n_freq,), Hz."""
    inertance: Complexes
    """(n_freq, n_out, n_in), kg^-1."""
    coherence: Reals
    """(n_freq, n_out, n_in)."""
    force: Reals
    """(n_freq, n_out, n_in), N^2/Hz."""
    response: Reals
    """(n_freq, n_out, n_in), (m/s^2)^2/Hz."""


def frequency_response(
    bars: Bars, plan: Plan, run: Run, effects: Sequence[Effect], omega: Reals
) -> tuple[Reals | Complexes, Complexes]:
    """Return force over source (n_freq,), and accelerations over force (n_freq, n_out) of a run."""
    loads = [each for node in run.true for each in translations(bars, node, plan.accelerometer_mass)]
    loads += [each for effect in effects for each in effect.attachments(bars, run)]
    columns = [bars.column(run.drive, Y), *(bars.column(node, Y) for node in run.true)]
    alpha = bars.attached(columns, loads, omega)
    flexibility = sum((effect.stinger_flexibility(omega, plan.armature_mass) for effect in effects), 0.0)
    mass = 0.0 if plan.hammer else plan.armature_mass
    force = 1 / (1 - mass * omega**2 * (alpha[:, 0, 0] + flexibility))
    return force, np.asarray(-(omega**2)[:, None] * alpha[:, 1:, 0])


def measure(bars: Bars, plan: Plan, effects: Sequence[Effect], rng: np.random.Generator) -> Measured:
    """Return what a test measures of bars with effects."""
    for effect in effects:
        bars = effect.altered(bars)
    runs = plan.runs
    for effect in effects:
        runs = effect.true_runs(runs)
    signals = [_signals(bars, plan, run, effects, rng) for run in runs]
    level = float(np.median([np.sqrt((x**2).mean()) for _, responses in signals for x in responses]))
    spectra = []
    for index, (force, responses) in enumerate(signals):
        force = force + 0.1 * plan.noise * np.sqrt((force**2).mean()) * rng.standard_normal(force.shape)
        noisy = []
        for response in responses:
            x = response + plan.noise * level * rng.standard_normal(response.shape)
            for effect in effects:
                hum = effect.hum(x.size, 1 / (plan.n_samples * plan.spacing), level, rng)
                x = x + np.reshape(hum, x.shape) if np.ndim(hum) else x
            noisy.append(x if plan.hammer else _filtered(x, plan, effects, index))
        spectra.append(_averaged(force, noisy, plan))
    return _handed_over(spectra, plan)


def _filtered(x: Reals, plan: Plan, effects: Sequence[Effect], response: int) -> Reals:
    """Return records (averages, n_samples) of a shaker test through filters; under Hann one long record."""
    long = x.reshape(1, -1) if plan.hann else x
    freq = np.fft.rfftfreq(long.shape[-1], 1 / (plan.n_samples * plan.spacing))
    spectrum, omega = np.fft.rfft(long), np.asarray(2 * np.pi * freq, np.float64)
    spectrum = spectrum * _filter(effects, response, omega)
    return np.asarray(np.fft.irfft(spectrum, long.shape[-1]).reshape(x.shape))


def _filter(effects: Sequence[Effect], response: int, omega: Reals | Complexes) -> Complexes:
    """Return by what all filters multiply a response's spectrum, (n_freq,)."""
    filters = [effect.filter(response, omega) for effect in effects]
    return np.asarray(np.prod(np.broadcast_arrays(np.ones(len(omega), complex), *filters), axis=0))


def _signals(
    bars: Bars, plan: Plan, run: Run, effects: Sequence[Effect], rng: np.random.Generator
) -> tuple[Reals, list[Reals]]:
    """Return records of force and accelerations of a run, (averages, n_samples) each, without noise."""
    n, n_records = plan.n_samples, plan.averages
    rate = n * plan.spacing  # Hz
    if plan.hammer:
        return _blows(bars, plan, run, effects, rng)
    samples, rows = (n * n_records, 1) if plan.hann else (n, n_records)
    freq = np.asarray(np.fft.rfftfreq(samples, 1 / rate), np.float64)
    driven = (freq > 0) & (freq < plan.frequency_max + plan.spacing / 2)
    source = driven * (rng.standard_normal((rows, len(freq))) + 1j * rng.standard_normal((rows, len(freq))))
    freq[0] = freq[1] / 100
    transfer, inertance = frequency_response(bars, plan, run, effects, 2 * np.pi * freq)
    force = source * transfer
    records = [np.fft.irfft(force * column, samples).reshape(n_records, n) for column in inertance.T]
    return np.fft.irfft(force, samples).reshape(n_records, n), records


def _blows(
    bars: Bars, plan: Plan, run: Run, effects: Sequence[Effect], rng: np.random.Generator
) -> tuple[Reals, list[Reals]]:
    """Return records of blows of one shape and different size.

    Along a line below the real axis of frequency every response has faded when its spectrum repeats itself.
    A filter acts on the endless response: of a record that ends while the structure rings it would carry
    the end to the beginning.
    """
    n, samples, rate = plan.n_samples, LONG * plan.n_samples, plan.n_samples * plan.spacing
    time, start = np.arange(samples) / rate, 0.05 / plan.spacing
    duration = PULSE / plan.frequency_max
    pulse = np.where(np.abs(time - start) < duration, np.cos(np.pi * (time - start) / duration) + 1, 0.0)
    decay = -np.log(FADED) * plan.spacing / LONG
    source = np.fft.rfft(pulse * np.exp(-decay * time))
    omega = 2 * np.pi * np.fft.rfftfreq(samples, 1 / rate) - 1j * decay
    _, inertance = frequency_response(bars, plan, run, effects, omega)
    filters = [_filter(effects, place, omega) for place in range(inertance.shape[1])]
    scale = np.exp(0.2 * rng.standard_normal(plan.averages))[:, None]
    grown = np.exp(decay * time[:n])
    spectra = [source * column * each for column, each in zip(inertance.T, filters, strict=True)]
    records = [scale * grown * np.fft.irfft(spectrum, samples)[:n] for spectrum in spectra]
    return scale * pulse[:n], records


def _window(plan: Plan) -> Reals:
    place = np.arange(plan.n_samples) / plan.n_samples
    if plan.hammer:
        return np.asarray(WINDOW_END**place)
    return np.asarray(1 - np.cos(2 * np.pi * place)) if plan.hann else np.ones(plan.n_samples)


def _averaged(force: Reals, responses: Sequence[Reals], plan: Plan) -> tuple[Reals, Complexes, Reals]:
    """Return G_ff (n_lines,), G_fx and G_xx (n_out, n_lines)."""
    n = plan.n_samples
    weights = _window(plan)
    lines = slice(None, plan.n_lines)
    scale = 2 / (n**2 * plan.spacing * (weights**2).mean())
    f = np.fft.rfft(weights * force)[:, lines]
    x = np.array([np.fft.rfft(weights * response)[:, lines] for response in responses])
    cross = scale * (f.conj() * x).mean(axis=1)
    return scale * (np.abs(f) ** 2).mean(axis=0), cross, scale * (np.abs(x) ** 2).mean(axis=1)


def _handed_over(spectra: Sequence[tuple[Reals, Complexes, Reals]], plan: Plan) -> Measured:
    """Return H1 and coherence at the lines that are kept."""
    ff = np.array([power for power, _, _ in spectra])[:, None]
    fx, xx = (np.array([each[i] for each in spectra]) for i in (1, 2))
    ff = np.broadcast_to(ff, xx.shape)
    if plan.hammer:  # runs are inputs
        arrays = [np.transpose(each, (2, 1, 0)) for each in (fx / ff, np.abs(fx) ** 2 / (ff * xx), ff, xx)]
    else:
        arrays = [np.transpose(each, (2, 0, 1)) for each in (fx / ff, np.abs(fx) ** 2 / (ff * xx), ff, xx)]
    keep = slice(plan.n_lines - len(plan.freq), None)
    h, coherence, force, response = (each[keep] for each in arrays)
    return Measured(plan.freq, h, np.clip(coherence.real, 0, 1), force.real, response.real)

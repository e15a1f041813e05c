"""One mode as lines that something spoils: windows, noise."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.single_mode.method import ModeFit

FREQ: FloatArray = np.arange(80.0, 122.0)  # lines of 1 Hz, so that a bandwidth in Hz is one in lines
AVERAGES = 100.0
NOISE = 0.05  # of magnitude and of phase, at every line
FLOOR = 0.01  # of the highest line, on each part of every line
POINTS, REACH = 400, 40  # quadrature of the convolution: points a line, lines to either side
HANN = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(1024) / 1024)


@dataclass(frozen=True, eq=False)
class Lines:
    """One measured FRF, inertance, and how sure each line is."""

    values: ComplexArray
    coherence: FloatArray | None
    leakage: WindowLeakage | None = None


Spoil = Callable[[ModeFit, np.random.Generator], Lines]


def clean(mode: ModeFit, _rng: np.random.Generator) -> Lines:
    """Return the mode and a constant."""
    return Lines(_inertance(mode, FREQ), None)


def hann_h1(mode: ModeFit, _rng: np.random.Generator) -> Lines:
    """Return the expected H1 of white force through a Hann window, not averaging."""
    ff, fx, xx = _leaked(mode)
    return Lines(fx / ff, np.abs(fx) ** 2 / (ff * xx), WindowLeakage.from_window(HANN, "h1"))


def hann_h2(mode: ModeFit, _rng: np.random.Generator) -> Lines:
    """Return the expected H2 of the same."""
    ff, fx, xx = _leaked(mode)
    return Lines(
        np.asarray(xx / fx.conj()), np.abs(fx) ** 2 / (ff * xx), WindowLeakage.from_window(HANN, "h2")
    )


def noisy(mode: ModeFit, rng: np.random.Generator) -> Lines:
    """Return lines each wrong by the same part of itself."""
    values = _inertance(mode, FREQ)
    return _with_error(values, NOISE * np.abs(values), rng)


def on_a_floor(mode: ModeFit, rng: np.random.Generator) -> Lines:
    """Return lines all wrong by the same amount."""
    values = _inertance(mode, FREQ)
    return _with_error(values, np.full(len(FREQ), FLOOR * np.abs(values).max()), rng)


def drawn_h1(mode: ModeFit, rng: np.random.Generator) -> Lines:
    """Return H1 of a finite number of averages through a Hann window."""
    ff, fx, xx = _simulate(mode, rng)
    return Lines(fx / ff, np.abs(fx) ** 2 / (ff * xx), WindowLeakage.from_window(HANN, "h1"))


def drawn_h2(mode: ModeFit, rng: np.random.Generator) -> Lines:
    """Return H2 of the same."""
    ff, fx, xx = _simulate(mode, rng)
    return Lines(
        np.asarray(xx / fx.conj()), np.abs(fx) ** 2 / (ff * xx), WindowLeakage.from_window(HANN, "h2")
    )


def _simulate(mode: ModeFit, rng: np.random.Generator) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return spectra averaged from Gaussian lines with the expected ones."""
    ff, fx, xx = _leaked(mode)
    shape = (2, len(ff), int(AVERAGES))
    first, second = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)
    force = np.sqrt(ff)[:, None] * first
    residual_error = np.sqrt(xx - np.abs(fx) ** 2 / ff)
    motion = (fx / ff)[:, None] * force + residual_error[:, None] * second
    products = np.abs(force) ** 2, force.conj() * motion, np.abs(motion) ** 2
    return products[0].mean(axis=1), products[1].mean(axis=1), products[2].mean(axis=1)


CONDITIONS: dict[str, Spoil] = {
    "clean": clean,
    "Hanning H1": hann_h1,
    "Hanning H2": hann_h2,
    "5 % noise": noisy,
    "floor noise": on_a_floor,
}


SPECTRA: dict[str, Spoil] = {
    "H1, expected": hann_h1,
    "H1, drawn": drawn_h1,
    "H2, expected": hann_h2,
    "H2, drawn": drawn_h2,
}
RANDOM = (noisy, on_a_floor, drawn_h1, drawn_h2)


def _inertance(mode: ModeFit, freq: FloatArray) -> ComplexArray:
    return np.asarray(-((2 * np.pi * freq) ** 2) * mode.response(freq))


def _with_error(values: ComplexArray, error: FloatArray, rng: np.random.Generator) -> Lines:
    """Return lines with `error` on each part, and the coherence that says so."""
    noise = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    square = 2 * (error / np.abs(values)) ** 2
    return Lines(values + error * noise, 1 / (1 + AVERAGES * square))


@cache
def _leaked(mode: ModeFit) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return the expected spectra of white force and response, convolved by quadrature [5.11, 5.12]."""
    x = (np.arange(-REACH * POINTS, REACH * POINTS) + 0.5) / POINTS
    share = 2 / 3 * (np.sinc(x) / (1 - x**2)) ** 2 / POINTS
    inertance = _inertance(mode, FREQ[:, None] + x)
    return np.full(len(FREQ), share.sum()), inertance @ share, np.abs(inertance) ** 2 @ share

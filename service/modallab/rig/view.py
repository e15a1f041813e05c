"""How the analyser's lines see a spectrum: the window's line shape over quadrature nodes."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import WINDOWS, Window
from modallab.rig.setup import Analyser

POINTS = 10  # Gauss points a panel: 1e-8 of a spectrum for panels no longer than `refined` makes them
COARSE = 4  # points a line of the unrefined grid, for a first look over many hypotheses


@dataclass(frozen=True, eq=False)
class View:
    """Where a spectrum has to be known, and what each line takes from there.

    `mirrored` brings in the negative frequencies, where spectra are conjugate; without kernels
    every line sees its own frequency alone.
    """

    nodes: FloatArray  # (n_nodes,) Hz
    near: FloatArray | None = None  # (n_lines, n_nodes)
    mirrored: FloatArray | None = None

    def through(self, spectrum: ComplexArray) -> ComplexArray:
        """Return a spectrum at the nodes (n_run, n_nodes, k) as the lines see it, (n_run, n_lines, k)."""
        if self.near is None or self.mirrored is None:
            return spectrum
        n_run, n_nodes, k = spectrum.shape
        flat = spectrum.swapaxes(0, 1).reshape(n_nodes, n_run * k)
        seen = np.empty((len(self.near), n_run * k), complex)
        seen.real = (self.near + self.mirrored) @ flat.real
        seen.imag = (self.near - self.mirrored) @ flat.imag
        return seen.reshape(len(self.near), n_run, k).swapaxes(0, 1)


@lru_cache(maxsize=16)
def periodic_view(analyser: Analyser, step: int = 1) -> View:
    """Return how every `step`-th line sees a signal that repeats with the record: lines see lines."""
    line = np.arange(analyser.n_lines, dtype=float)
    if analyser.window == "rectangular":  # its line shape is 1 at its own line and 0 at all others
        return View(analyser.freq[::step])
    window = WINDOWS[analyser.window]
    own = line[::step, None]
    return View(analyser.freq, window.line_shape(own - line), window.line_shape(own + line) * (line > 0))


def refined_view(analyser: Analyser, poles: FloatArray, widths: FloatArray) -> View:
    """Return how the lines see a stationary signal, by quadrature refined towards resonances.

    Parameters
    ----------
    poles, widths
        Frequencies and half bandwidths, Hz, of any shape.
    """
    return _view(analyser, *refined(analyser, poles, widths))


@lru_cache(maxsize=16)
def coarse_view(analyser: Analyser, step: int) -> View:
    """Return how every `step`-th line sees a stationary signal, on a grid that knows no resonance."""
    return _view(analyser, *_gauss(analyser.freq[:-1], analyser.freq[1:], COARSE), step)


def _view(analyser: Analyser, nodes: FloatArray, weights: FloatArray, step: int = 1) -> View:
    window: Window = WINDOWS[analyser.window]
    lines = np.arange(0, analyser.n_lines, step, dtype=float)
    place, share = nodes / analyser.spacing, weights / analyser.spacing
    near, mirrored = window.line_shapes(lines, place), window.line_shapes(lines, -place)
    near *= share
    mirrored *= share
    return View(nodes, near, mirrored)


def refined(analyser: Analyser, poles: FloatArray, widths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes and weights, (n_nodes,) Hz, from 0 Hz to the top of the band.

    Panels of one line are halved until none is longer than twice its distance from any pole, which
    makes the error of a panel fall by 2.4^-20 or more with ten points (Bernstein ellipse).
    """
    flat, half = poles.ravel(), np.maximum(widths.ravel(), 1e-6 * analyser.spacing)
    inside = (flat > -analyser.spacing) & (flat < analyser.frequency_max + analyser.spacing)
    flat, half = flat[inside], half[inside]
    left, right = analyser.freq[:-1], analyser.freq[1:]
    done: list[FloatArray] = []
    while len(left):
        centre, radius = (left + right) / 2, (right - left) / 2
        gap = np.maximum(np.abs(centre[:, None] - flat) - radius[:, None], 0.0)
        near = np.sqrt(gap**2 + half**2).min(axis=1, initial=np.inf)
        fine = radius <= near
        done.append(np.stack([left[fine], right[fine]]))
        left, centre, right = left[~fine], centre[~fine], right[~fine]
        left, right = np.concatenate([left, centre]), np.concatenate([centre, right])
    panels = np.concatenate(done, axis=1)
    return _gauss(panels[0], panels[1], POINTS)


def _gauss(left: FloatArray, right: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    centre, radius = ((left + right) / 2)[:, None], ((right - left) / 2)[:, None]
    return (centre + radius * x).ravel(), (radius * w).ravel()

"""Kernels between true spectra and the analyser's lines."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import coo_array, csr_array

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.rig.acquisition import samples_of
from modallab.rig.analyser import Analyser
from modallab.rig.leakage_kernel import LeakageKernel, leak_spectrum
from modallab.rig.line_selection import LineSelection
from modallab.rig.spectrum_settings import QUADRATURE


@dataclass(frozen=True, eq=False)
class LineKernel:
    """Frequencies at which a spectrum is evaluated, and their weights in each line.

    `mirrored` brings in the negative frequencies, where spectra are conjugate; without kernels
    every line sees its own frequency alone.
    """

    nodes: FloatArray
    """(n_nodes,) Hz, quadrature nodes."""
    near: FloatArray | csr_array | None = None
    """(n_lines, n_nodes) line shape at nodes near each line."""
    mirrored: FloatArray | csr_array | None = None

    @cached_property
    def _parts(self) -> tuple[FloatArray | csr_array, FloatArray | csr_array]:
        """(n_lines, n_nodes) each: for real parts of spectra, and for imaginary ones."""
        assert self.near is not None
        assert self.mirrored is not None
        return self.near + self.mirrored, self.near - self.mirrored

    def convolve(self, spectrum: ComplexArray) -> ComplexArray:
        """Return a spectrum (n_run, n_nodes, k) as seen by the lines, (n_run, n_lines, k)."""
        if self.near is None or self.mirrored is None:
            return spectrum
        n_run, n_nodes, k = spectrum.shape
        flat = spectrum.swapaxes(0, 1).reshape(n_nodes, n_run * k)
        even, odd = self._parts
        line_spectrum = np.zeros((even.shape[0], n_run * k), complex)
        line_spectrum.real = even @ np.ascontiguousarray(flat.real)
        is_complex = flat.imag.any(axis=0)  # an auto spectrum has no imaginary part
        line_spectrum.imag[:, is_complex] = odd @ flat.imag[:, is_complex]
        return line_spectrum.reshape(len(line_spectrum), n_run, k).swapaxes(0, 1)


@lru_cache(maxsize=16)
def periodic_kernel(analyser: Analyser, lines: LineSelection | None = None) -> LineKernel:
    """Return the kernel of some lines, or of all, for a signal that is periodic in the record."""
    window, n = analyser.line_window, analyser.n_lines
    line = np.arange(n) if lines is None else lines.indices
    reach = len(window.coefficients) - 1  # farther off, its line shape is 0 at whole lines
    if reach == 0:  # and 1 at its own line
        return LineKernel(analyser.freq[line])
    offset = np.arange(-reach, reach + 1)
    shape = np.broadcast_to(window.line_shape(offset.astype(float)), (len(line), len(offset)))
    neighbour = line[:, None] + offset
    source, in_band = np.abs(neighbour), np.abs(neighbour) < n
    needed = np.unique(source[in_band])

    def matrix(entries: BoolArray) -> csr_array:
        rows = np.broadcast_to(np.arange(len(line))[:, None], source.shape)
        columns = np.searchsorted(needed, source[entries])
        size = len(line), len(needed)
        return csr_array(coo_array((shape[entries], (rows[entries], columns)), size))

    return LineKernel(
        analyser.freq[needed], matrix(in_band & (neighbour >= 0)), matrix(in_band & (neighbour < 0))
    )


def refined_kernel(
    analyser: Analyser, poles: FloatArray, widths: FloatArray, points: int = QUADRATURE.gauss_points
) -> LeakageKernel:
    """Return the kernel of the lines for a stationary signal, refined near resonances.

    Parameters
    ----------
    poles, widths
        Frequencies and half bandwidths, Hz, of any shape.
    points
        Of a panel.
    """
    grid = refined_panels(analyser, poles, widths, points)
    window, n_samples = analyser.line_window_kind, samples_of(analyser)
    return leak_spectrum(window, analyser.n_lines, analyser.spacing, *grid, n_samples)


@lru_cache(maxsize=16)
def coarse_kernel(analyser: Analyser, lines: LineSelection) -> LineKernel:
    """Return the kernel of some lines for a stationary signal, on a uniform grid.

    Even steps of half a line: of smooth functions no rule of as many points is better, and a window's
    line shape squared holds no finer detail.
    """
    positions = (
        np.arange(QUADRATURE.coarse_points * (analyser.n_lines - 1)) + 0.5
    ) / QUADRATURE.coarse_points
    window = analyser.line_window
    n = samples_of(analyser)
    near, mirrored = (
        window.line_shapes(lines.indices.astype(float), position, n) / QUADRATURE.coarse_points
        for position in (positions, -positions)
    )
    return LineKernel(positions * analyser.spacing, near, mirrored)


def refined_panels(
    analyser: Analyser, poles: FloatArray, widths: FloatArray, points: int = QUADRATURE.gauss_points
) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes and weights, (n_nodes,) Hz, from 0 Hz to the top of the band.

    Panels of one line are halved until none is longer than twice its distance from any pole, which
    makes the error of a panel fall by 2.4^-20 or more with ten points (Bernstein ellipse).
    """
    flat, half = poles.ravel(), np.maximum(widths.ravel(), QUADRATURE.min_half_width * analyser.spacing)
    inside = (flat > -analyser.spacing) & (flat < analyser.frequency_max + analyser.spacing)
    flat, half = flat[inside], half[inside]
    lower, upper = analyser.freq[:-1], analyser.freq[1:]
    panels_done: list[FloatArray] = []
    while len(lower):
        centre, radius = (lower + upper) / 2, (upper - lower) / 2
        distance = np.maximum(np.abs(centre[:, None] - flat) - radius[:, None], 0.0)
        near = np.sqrt(distance**2 + half**2).min(axis=1, initial=np.inf)
        is_fine = radius <= near
        panels_done.append(np.stack([lower[is_fine], upper[is_fine]]))
        lower, centre, upper = lower[~is_fine], centre[~is_fine], upper[~is_fine]
        lower, upper = np.concatenate([lower, centre]), np.concatenate([centre, upper])
    panels = np.concatenate(panels_done, axis=1)
    return _gauss(panels[0], panels[1], points)


def _gauss(lower: FloatArray, upper: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    centre, radius = ((lower + upper) / 2)[:, None], ((upper - lower) / 2)[:, None]
    return (centre + radius * x).ravel(), (radius * w).ravel()

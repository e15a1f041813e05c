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
from modallab.rig.spectrum_settings import LEAKAGE_KERNEL, QUADRATURE


@dataclass(frozen=True, eq=False)
class LineKernel:
    """Frequencies at which a spectrum is evaluated, and their weights in each line.

    `mirrored` brings in the negative frequencies, where spectra are conjugate; without kernels
    every line sees its own frequency alone.
    """

    nodes: FloatArray
    """(n_nodes,) Hz, quadrature nodes."""
    near: csr_array | None = None
    """(n_lines, n_nodes) line shape at nodes near each line."""
    mirrored: csr_array | None = None
    far: FloatArray | None = None
    """(n_lines, n_blocks) line shape at blocks of as many nodes each, away from each line; None: none."""
    far_mirrored: FloatArray | None = None

    @cached_property
    def _parts(self) -> tuple[csr_array, csr_array]:
        """(n_lines, n_nodes) each: for real parts of spectra, and for imaginary ones."""
        assert self.near is not None
        assert self.mirrored is not None
        return csr_array(self.near + self.mirrored), csr_array(self.near - self.mirrored)

    @cached_property
    def _far_parts(self) -> tuple[FloatArray, FloatArray] | None:
        """(n_lines, n_blocks) each, as `_parts`."""
        if self.far is None or self.far_mirrored is None:
            return None
        return self.far + self.far_mirrored, self.far - self.far_mirrored

    def _seen(self, values: FloatArray, part: int) -> FloatArray:
        """Return values (n_nodes, k) as seen by the lines: real parts for 0, imaginary parts for 1."""
        seen = self._parts[part] @ values
        if self._far_parts is not None:
            far = self._far_parts[part]
            starts = np.arange(far.shape[1]) * QUADRATURE.coarse_points * QUADRATURE.block_lines
            seen += far @ np.add.reduceat(values, starts, axis=0)
        return np.asarray(seen)

    def convolve(self, spectrum: ComplexArray) -> ComplexArray:
        """Return a spectrum (n_run, n_nodes, k) as seen by the lines, (n_run, n_lines, k)."""
        if self.near is None or self.mirrored is None:
            return spectrum
        n_run, n_nodes, k = spectrum.shape
        flat = spectrum.swapaxes(0, 1).reshape(n_nodes, n_run * k)
        line_spectrum = np.zeros((self.near.shape[0], n_run * k), complex)
        line_spectrum.real = self._seen(np.ascontiguousarray(flat.real), 0)
        is_complex = flat.imag.any(axis=0)  # an auto spectrum has no imaginary part
        line_spectrum.imag[:, is_complex] = self._seen(flat.imag[:, is_complex], 1)
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
    analyser: Analyser,
    poles: FloatArray,
    widths: FloatArray,
    points: int = QUADRATURE.gauss_points,
    far_points: int = LEAKAGE_KERNEL.n_points,
) -> LeakageKernel:
    """Return the kernel of the lines for a stationary signal, refined near resonances.

    Parameters
    ----------
    poles, widths
        Frequencies and half bandwidths, Hz, of any shape.
    points
        Of a panel.
    far_points
        Of a line, for what leaks from afar.
    """
    grid = refined_panels(analyser, poles, widths, points)
    window, n_samples = analyser.line_window_kind, samples_of(analyser)
    return leak_spectrum(window, analyser.n_lines, analyser.spacing, *grid, n_samples, far_points)


@lru_cache(maxsize=16)
def coarse_kernel(analyser: Analyser, lines: LineSelection) -> LineKernel:
    """Return the kernel of some lines for a stationary signal, on a uniform grid.

    Even steps of half a line: of smooth functions no rule of as many points is better, and a window's
    line shape squared holds no finer detail. Away from a line, blocks of nodes count as one: memory goes
    with the number of lines, not with its square.
    """
    points, n = QUADRATURE.coarse_points, samples_of(analyser)
    window, line = analyser.line_window, lines.indices.astype(float)
    positions = (np.arange(points * (analyser.n_lines - 1)) + 0.5) / points
    node_weight = np.sin(np.pi * positions) ** 2 / points
    size = points * QUADRATURE.block_lines
    centre = (np.arange(-(-len(positions) // size)) + 0.5) * QUADRATURE.block_lines

    def parts(sign: int) -> tuple[csr_array, FloatArray]:
        distance = line[:, None] - sign * centre
        is_near = np.abs(distance) < QUADRATURE.near_lines
        row, block = np.nonzero(is_near)
        column = block[:, None] * size + np.arange(size)
        exists = column < len(positions)
        row, column = np.broadcast_to(row[:, None], column.shape)[exists], column[exists]
        shape = node_weight[column] * window.envelope(line[row] - sign * positions[column], n)
        near = csr_array(coo_array((shape, (row, column)), (len(line), len(positions))))
        mean_weight = 0.5 / points  # of a squared sine over a line
        far = mean_weight * window.envelope(np.where(is_near, QUADRATURE.near_lines, distance), n)
        return near, np.where(is_near, 0.0, far)

    (near, far), (mirrored, far_mirrored) = parts(1), parts(-1)
    return LineKernel(positions * analyser.spacing, near, mirrored, far, far_mirrored)


def refined_panels(
    analyser: Analyser, poles: FloatArray, widths: FloatArray, points: int = QUADRATURE.gauss_points
) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes and weights, (n_nodes,) Hz, from 0 Hz to the top of the band.

    Panels of one line, or up to an end of the source's band, are halved until none is longer than twice its
    distance from any pole, which makes the error of a panel fall by 2.4^-20 or more with ten points
    (Bernstein ellipse).
    """
    flat, half = poles.ravel(), np.maximum(widths.ravel(), QUADRATURE.min_half_width * analyser.spacing)
    inside = (flat > -analyser.spacing) & (flat < analyser.frequency_max + analyser.spacing)
    ends = np.union1d(analyser.freq, analyser.band_ends_between_lines)
    return panels_near_poles(ends[:-1], ends[1:], flat[inside], half[inside], points)


def panels_near_poles(
    lower: FloatArray, upper: FloatArray, poles: FloatArray, half_widths: FloatArray, points: int
) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes and weights, (n_nodes,) Hz, of panels that are halved towards poles.

    Parameters
    ----------
    lower, upper
        (n,) Hz, ends of the panels before they are halved.
    poles, half_widths
        (n_poles,) Hz.
    """
    panels_done = [np.zeros((2, 0))]
    while len(lower):
        centre, radius = (lower + upper) / 2, (upper - lower) / 2
        distance = np.maximum(np.abs(centre[:, None] - poles) - radius[:, None], 0.0)
        near = np.sqrt(distance**2 + half_widths**2).min(axis=1, initial=np.inf)
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

"""Averages over cells of a uniform grid and between frequencies, where peaks are narrower than these."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.rig.line_kernels import panels_near_poles
from modallab.rig.nonlinear_settings import DISTORTION
from modallab.rig.spectrum_settings import QUADRATURE


@dataclass(frozen=True, eq=False)
class CellAverages:
    """Weights of a spectrum's average about each point of a uniform grid near narrow resonances.

    Samples of a peak that is narrower than a few cells depend on where the peak lies between two points of
    the grid; averages with a triangular weight two cells wide do not, and keep its power and its place.
    """

    points: IntArray
    """(n_points,) indices of the grid points."""
    nodes: FloatArray
    """(n_nodes,) Hz, at which the spectrum is needed."""
    weights: csr_array
    """(n_points, n_nodes)."""

    @classmethod
    def near(cls, spacing: float, n_lines: int, poles: FloatArray, half_widths: FloatArray) -> "CellAverages":
        """Return the averages of a grid from 0 Hz on, near poles that it does not resolve.

        Parameters
        ----------
        spacing
            Hz, of the grid.
        n_lines
            Points of the grid.
        poles, half_widths
            (n_poles,) Hz, halves of half-power bandwidths.
        """
        narrow = half_widths < DISTORTION.resolved_half_width * spacing
        poles = poles[narrow]
        half = np.maximum(half_widths[narrow], DISTORTION.min_half_width * spacing)
        reach = np.arange(-DISTORTION.averaged_cells, DISTORTION.averaged_cells)
        cells = np.unique(np.floor(poles / spacing).astype(int)[:, None] + reach)
        cells = cells[(cells >= 0) & (cells < n_lines - 1)]
        edges = spacing * np.arange(n_lines, dtype=np.float64)
        nodes, hertz = panels_near_poles(edges[cells], edges[cells + 1], poles, half, QUADRATURE.gauss_points)
        whole = np.isin(cells - 1, cells)  # a point between two of the cells
        points = cells[whole]
        place = nodes / spacing
        left = np.floor(place).astype(int)
        row, column, weight = (
            np.concatenate([left, left + 1]),
            np.tile(np.arange(len(nodes)), 2),
            np.concatenate([1 - (place - left), place - left]) * np.tile(hertz, 2) / spacing,
        )
        kept = np.isin(row, points)
        rows = np.searchsorted(points, row[kept])
        shape = (len(points), len(nodes))
        return cls(points, nodes, csr_array((weight[kept], (rows, column[kept])), shape=shape))


def mean_about(freq: FloatArray, grid: FloatArray, values: FloatArray) -> FloatArray:
    """Return means (n,) of a sampled curve about frequencies, with triangular weights.

    What lies between two frequencies counts for both, by its distance: a quadrature over them keeps power
    and place of a peak there. Where they are closer than the grid, values are interpolated.

    Parameters
    ----------
    freq
        (n,) Hz, in any order.
    grid
        (n_grid,) Hz, uniform, from 0 Hz on.
    values
        (n_grid,) real.
    """
    order = np.argsort(freq)
    rising = freq[order]
    means = np.interp(rising, grid, values)
    gaps = np.diff(rising)
    wide = np.flatnonzero(np.minimum(gaps[1:], gaps[:-1]) > grid[1] * (1 + COMPARISON_ROUNDING)) + 1
    slopes = np.diff(_integrated_twice(rising, grid, values)) / np.where(gaps > 0, gaps, np.inf)
    means[wide] = 2 * (slopes[wide] - slopes[wide - 1]) / (rising[wide + 1] - rising[wide - 1])
    result = np.empty(len(freq))
    result[order] = means
    return result


def _integrated_twice(freq: FloatArray, grid: FloatArray, values: FloatArray) -> FloatArray:
    """Return the double integral (n,) from 0 Hz of a curve that is linear between the points of a grid."""
    spacing = grid[1]
    once = np.concatenate([[0.0], np.cumsum(spacing * (values[1:] + values[:-1]) / 2)])
    steps = spacing * once[:-1] + spacing**2 * (2 * values[:-1] + values[1:]) / 6
    twice = np.concatenate([[0.0], np.cumsum(steps)])
    left = np.clip((freq / spacing).astype(int), 0, len(grid) - 2)
    x = freq - left * spacing
    slope = (values[left + 1] - values[left]) / spacing
    return np.asarray(twice[left] + x * (once[left] + x * (values[left] / 2 + x * slope / 6)))

"""Leakage of stationary spectra into all lines, in a time proportional to the number of lines."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from scipy.sparse import coo_array, csr_array

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import WINDOWS, Window
from modallab.rig.spectrum_settings import LEAKAGE_KERNEL


@dataclass(frozen=True, eq=False)
class LeakageKernel:
    """Convolution with the window's line shape: exact for near nodes, interpolated for distant ones.

    Spectra are conjugate at negative frequency, so that every node has a mirror.
    """

    nodes: FloatArray
    """(n_nodes,) Hz, quadrature nodes."""
    near: csr_array
    """(n_lines, n_nodes) line shape at nodes near each line."""
    mirrored: csr_array
    gather: csr_array
    """(n_points * n_lines, n_nodes) interpolation matrix from nodes to the points of every line."""
    far: ComplexArray
    """(n_points, n_fft // 2 + 1, 1) transform of the line shape at the interpolation points."""
    n_fft: int

    def convolve(self, spectrum: ComplexArray) -> ComplexArray:
        """Return a spectrum (n_run, n_nodes, k) as seen by the lines, (n_run, n_lines, k)."""
        n_run, n_nodes, k = spectrum.shape
        n_lines = self.near.shape[0]
        flat = np.ascontiguousarray(spectrum.swapaxes(0, 1)).reshape(n_nodes, n_run * k)
        # Real and imaginary parts each on their own: an auto spectrum, which has but one, costs half.
        is_complex = flat.imag.any(axis=0)
        n_real = flat.shape[1]
        parts = np.concatenate([flat.real, flat.imag[:, is_complex]], axis=1)
        sign = np.ones(parts.shape[1])
        sign[n_real:] = -1.0  # of the mirror
        near_part = self.near @ parts + sign * (self.mirrored @ parts)
        far_points = (self.gather @ parts).reshape(len(self.far), n_lines, -1)
        sources = np.zeros((self.n_fft, parts.shape[1]))
        lines = np.zeros((self.far.shape[1], parts.shape[1]), complex)
        for far, points, mirror in zip(
            self.far, far_points, far_points[::-1], strict=True
        ):  # each lies in the cache
            sources[: n_lines - 1] = sources[2 * n_lines - 1 :] = 0.0
            sources[n_lines - 1 : 2 * n_lines - 1] = points
            sources[n_lines - 1 :: -1] += sign * mirror
            lines += far * scipy.fft.rfft(sources, axis=0)
        near_part += scipy.fft.irfft(lines, self.n_fft, axis=0)[n_lines - 1 : 2 * n_lines - 1]
        spectrum_at_lines = near_part[:, :n_real].astype(complex)
        spectrum_at_lines.imag[:, is_complex] = near_part[:, n_real:]
        return np.asarray(spectrum_at_lines.reshape(n_lines, n_run, k).swapaxes(0, 1))


def leak_spectrum(
    window: str,
    n_lines: int,
    spacing: float,
    nodes: FloatArray,
    weights: FloatArray,
    n_samples: int | None = None,
    n_points: int = LEAKAGE_KERNEL.n_points,
) -> LeakageKernel:
    """Return the leakage kernel of lines `spacing` Hz apart, for quadrature nodes and weights in Hz.

    Nodes lie between the first and the last line, none of them on a line.

    Parameters
    ----------
    n_samples
        Of a record, 2.5 n_lines and more; None: of continuous time.
    n_points
        Interpolation points of a line for what leaks from afar.
    """
    shape = WINDOWS[window]
    line = np.round(nodes / spacing)
    offset = nodes / spacing - line
    node_weight = np.sin(np.pi * offset) ** 2 * weights / spacing
    n_near = _nearby(shape, n_lines)
    line_distance = np.arange(1 - n_near, n_near)[:, None]
    line_index = line.astype(int)
    return LeakageKernel(
        nodes,
        _matrix(
            line_index + line_distance,
            shape.envelope(line_distance - offset, n_samples) * node_weight,
            n_lines,
        ),
        _matrix(
            line_distance - line_index,
            shape.envelope(line_distance + offset, n_samples) * node_weight,
            n_lines,
        ),
        _matrix(
            line_index + n_lines * np.arange(n_points)[:, None],
            _lagrange(offset, n_points) * node_weight,
            n_points * n_lines,
        ),
        _far(window, n_lines, n_samples, n_points),
        _n_fft(n_lines),
    )


def _matrix(rows: FloatArray, values: FloatArray, n_rows: int) -> csr_array:
    """Return values (k, n) in given rows (k, n) of their columns, (n_rows, n); rows beyond are left out."""
    is_inside = (rows >= 0) & (rows < n_rows)
    columns = np.broadcast_to(np.arange(rows.shape[1]), rows.shape)
    return csr_array(
        coo_array((values[is_inside], (rows[is_inside], columns[is_inside])), (n_rows, rows.shape[1]))
    )


def _nearby(window: Window, n_lines: int) -> int:
    reach = LEAKAGE_KERNEL.near_lines + len(window.coefficients) - 1
    # The poles of a sampled line shape come again after n_samples: among few lines nowhere is far from all.
    return reach if n_lines > 2 * reach else 2 * n_lines


def _points(n_points: int) -> FloatArray:
    """Return the Chebyshev points (n_points,) over one line, symmetric about it."""
    return np.asarray(-0.5 * np.cos(np.pi * (np.arange(n_points) + 0.5) / n_points))


def _lagrange(offset: FloatArray, n_points: int) -> FloatArray:
    """Return the Lagrange polynomials of the points, (n_points, n) at `offset` (n,) lines."""
    points = _points(n_points)
    distance = offset - points[:, None]
    denominator = np.where(np.eye(n_points, dtype=bool), 1.0, points[:, None] - points).prod(axis=1)
    lower_product, upper_product = (
        np.ones_like(distance),
        np.ones_like(distance),
    )  # products over the points on either side
    for i in range(1, n_points):
        lower_product[i] = lower_product[i - 1] * distance[i - 1]
        upper_product[-1 - i] = upper_product[-i] * distance[-i]
    return np.asarray(lower_product * upper_product / denominator[:, None])


@lru_cache(maxsize=8)
def _far(window: str, n_lines: int, n_samples: int | None, n_points: int) -> ComplexArray:
    """Return the Fourier transform of the line shape at the interpolation points of distant lines."""
    n_fft = _n_fft(n_lines)
    steps = np.arange(1 - n_lines, 2 * n_lines - 1)
    kernel = np.zeros((n_points, n_fft))
    far_lines = steps[np.abs(steps) >= _nearby(WINDOWS[window], n_lines)]
    kernel[:, far_lines % n_fft] = WINDOWS[window].envelope(far_lines - _points(n_points)[:, None], n_samples)
    return np.asarray(scipy.fft.rfft(kernel, axis=1)[:, :, None])


def _n_fft(n_lines: int) -> int:
    return int(scipy.fft.next_fast_len(3 * n_lines, real=True))

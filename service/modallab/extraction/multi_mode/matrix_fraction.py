"""Matrix fractions of all orders fitted to FRFs by linear least squares, from one set of sums.

The fraction is `H(z) = B(z) A(z)^-1`, `A(z) = I + A_1 z + ... + A_n z^n`, where
`z = exp(2 pi i (f - f_0)/(N df))`. Sums over the lines are Fourier sums, so the normal matrices consist of
Toeplitz blocks. After elimination of the numerators, the leading blocks of

    M = sum_o (T_o - S_o^H R_o^-1 S_o)

are the normal matrices of all lower orders, and one Cholesky factor solves them all. Because the lowest
coefficient is fixed, poles that only fit noise are unstable while those of the structure are stable.

References
----------
Guillaume, P., Verboven, P., Vanlanduit, S., Van der Auweraer, H. and Peeters, B. (2003), Proc. 21st
International Modal Analysis Conference, paper 183. Cauberghe, B., Guillaume, P., Verboven, P., Vanlanduit,
S. and Parloo, E. (2005), Mechanical Systems and Signal Processing 19, 909-919. Sanathanan, C. K. and
Koerner, J. (1963), IEEE Transactions on Automatic Control 8, 56-58.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.fft
import scipy.linalg

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING, SUM_ROUNDING
from modallab.extraction.multi_mode.chart_settings import MATRIX_FRACTION


@dataclass(frozen=True, eq=False)
class ZDomainData:
    """FRFs on an arc of the unit circle, scaled to equal size over inputs and outputs."""

    frf: ComplexArray
    """(n_out, n_in, n_freq), with the lines, over which all sums are taken, last."""
    weight: FloatArray
    """(n_out, n_freq) weight of an equation (row of the FRF matrix); (1, n_freq) if all are equal."""
    noise: FloatArray
    """(n_out, n_in, n_freq) E|error|^2 times the weight."""
    scale: FloatArray
    """(n_out, n_in) divisors of the FRFs."""
    points: int
    """Number N of points on the full circle."""

    def sums(self, values: ComplexArray | FloatArray, order: int) -> ComplexArray:
        """Return `sum_k values_k z_k^l` for the lags l = -order to order, on the last axis."""
        turned = scipy.fft.ifft(values, self.points, norm="forward")
        lags: ComplexArray = np.empty((*turned.shape[:-1], 2 * order + 1), complex)
        lags[..., :order] = turned[..., self.points - order :]
        lags[..., order:] = turned[..., : order + 1]
        return lags


@dataclass(frozen=True, eq=False)
class Fractions:
    """Denominators of all orders, with the matrices that give the numerators."""

    denominator: ComplexArray
    """(n_orders, n + 1, n_in, n_in) coefficients with A_0 = I, zero above the order."""
    numerator: ComplexArray
    """(n_out, n + 1, (n + 1) n_in) matrix from A to B."""
    noise: float
    """E|error|^2 estimated from the data over that implied by the weights."""


def to_z_domain(frf: ComplexArray, weight: FloatArray, order: int) -> ZDomainData:
    """Return the lines scaled and weighted for sums up to an order; other parameters as `GlobalMethod`.

    The error of an equation is that of the FRF times `|A|`. The total power of all FRFs has its peaks where
    `1/|A|^2` has them, so that weighting by it minimises the error of the FRFs in place of that of the
    equations.
    """
    by_lines = np.ascontiguousarray(frf.transpose(1, 2, 0))
    square = by_lines.real**2 + by_lines.imag**2
    mean = square.mean(axis=(0, 2))
    scale = np.where(mean > 0, mean, 1.0)[:, None]
    line_weight = weight.transpose(1, 2, 0)
    usable = line_weight.min(axis=1) > 0
    variance = np.divide(1 / scale, line_weight, out=np.zeros(line_weight.shape), where=usable[:, None])
    row = np.divide(1.0, variance.mean(axis=1), out=np.zeros(usable.shape), where=usable)
    power = (square / scale).sum(axis=1) * usable
    level = _level(row, power)[:, None]
    pattern = row / level * _gain(power)
    noise = variance * (pattern * level)[:, None]
    if (np.ptp(pattern, axis=0) <= COMPARISON_ROUNDING * pattern[0]).all():
        pattern = pattern[:1]
    frf_scale = np.sqrt(scale / level[:, None])
    arc = max(
        MATRIX_FRACTION.least_arc,
        2 / np.pi * np.arcsin(MATRIX_FRACTION.smallest_eigenvalue_ratio ** (1 / (2 * order))),
    )
    points = scipy.fft.next_fast_len(int(np.ceil(len(frf) / arc)))
    return ZDomainData(by_lines * (1 / frf_scale), pattern, noise, frf_scale[..., 0], points)


def _level(row: FloatArray, power: FloatArray) -> FloatArray:
    """Return the divisor of each FRF's weights, (n_out,), reduced for FRFs far above the others."""
    level = row.mean(axis=1)
    weighted_power = (row * power).sum(axis=1)
    ranked = np.sort(weighted_power[weighted_power > 0])
    loudest = MATRIX_FRACTION.largest_power_ratio * (ranked[len(ranked) // 2] if len(ranked) else 1.0)
    level = level * np.minimum(1.0, loudest / np.where(weighted_power > 0, weighted_power, loudest))
    return np.asarray(np.where(level > 0, level, 1.0))


def _gain(power: FloatArray) -> FloatArray:
    """Return the sum of normalised power spectra of the FRFs, (n_freq,), with a geometric mean of 1."""
    total = power.sum(axis=1)
    gain = 1 / np.where(total > 0, total, 1.0) @ power
    gain = np.maximum(gain, MATRIX_FRACTION.smallest_gain * (gain.max() or 1.0))
    return np.asarray(gain / np.exp(np.log(gain).mean()))


def fit_fractions(z_data: ZDomainData, orders: IntArray) -> Fractions:
    """Return the fractions of every order.

    Parameters
    ----------
    z_data
        From `to_z_domain`.
    orders
        (n_orders,) rising.
    """
    normal = _normal(z_data, int(orders[-1]))
    added = _noise_contribution(z_data, normal)
    level = _noise_level(_factor(normal.reduced, normal.total), added)
    compensated = replace(normal, reduced=normal.reduced - MATRIX_FRACTION.compensated_bias * level * added)
    return Fractions(compensated.solve(orders), normal.numerator, level)


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of the highest order, with the numerators eliminated."""

    reduced: ComplexArray
    """((n + 1) n_in, (n + 1) n_in) M; only the lower triangle is used."""
    total: ComplexArray
    """((n + 1) n_in, (n + 1) n_in) sum of all T_o."""
    inverse: ComplexArray
    """(n_out, n + 1, n + 1) R^-1; (1, ...) if all are equal."""
    numerator: ComplexArray
    """(n_out, n + 1, (n + 1) n_in) R^-1 S."""

    def solve(self, orders: IntArray) -> ComplexArray:
        """Return A of every order, (n_orders, n + 1, n_in, n_in)."""
        order = self.inverse.shape[1] - 1
        m = len(self.reduced) // (order + 1)
        inverse = _inverse(_factor(self.reduced[m:, m:], self.total)[None])[0]
        forward = inverse @ -self.reduced[m:, :m]
        in_order = np.arange(order * m)[:, None, None] < m * orders[:, None]
        truncated = np.where(in_order, forward[:, None, :], 0.0).reshape(order * m, -1)
        free = inverse.conj().T @ truncated
        solved = np.empty((len(orders), order + 1, m, m), complex)
        solved[:, 0] = np.eye(m)
        solved[:, 1:] = np.moveaxis(free.reshape(order, m, len(orders), m), 2, 0)
        return solved


def _normal(z_data: ZDomainData, order: int) -> _Normal:
    n_out, n_in, n_freq = z_data.frf.shape
    size = (order + 1) * n_in
    weighted = z_data.weight[:, None] * z_data.frf
    power = np.einsum("oik,ojk->ijk", weighted.conj(), z_data.frf)
    # one transform for all sums, because the overhead of a call is as large as the sums themselves
    rows = (weighted.reshape(-1, n_freq), power.reshape(-1, n_freq), z_data.weight)
    toeplitz = _toeplitz(z_data.sums(np.concatenate(rows), order))
    first, last = len(rows[0]), len(rows[0]) + len(rows[1])
    square = (order + 1, order + 1)
    output_blocks = toeplitz[:first].reshape(n_out, n_in, *square).transpose(0, 2, 3, 1)
    of_outputs = output_blocks.reshape(n_out, order + 1, size)
    total = toeplitz[first:last].reshape(n_in, n_in, *square).transpose(2, 0, 3, 1).reshape(size, size)
    numerator_blocks = toeplitz[last:]
    # R^-1 = F^H F: a difference of squares loses less to rounding than one with R^-1
    factor = _inverse(_factor(numerator_blocks, numerator_blocks))
    part = (factor @ of_outputs).reshape(-1, size)
    turned = factor.conj().transpose(0, 2, 1)
    numerator = turned @ part.reshape(of_outputs.shape)
    eliminated = scipy.linalg.blas.zherk(1.0, part.T).T  # part^H part, half the work of a general product
    return _Normal(total - eliminated, total, turned @ factor, numerator)


def _toeplitz(lags: ComplexArray) -> ComplexArray:
    """Return matrices whose element (j, k) is the lag k - j, (..., n + 1, n + 1)."""
    order = lags.shape[-1] // 2
    shape, stride = (*lags.shape[:-1], order + 1, order + 1), lags.strides[-1]
    strides = (*lags.strides[:-1], -stride, stride)
    return np.lib.stride_tricks.as_strided(lags[..., order:], shape, strides, writeable=False)


def _factor(matrices: ComplexArray, scale_matrices: ComplexArray) -> ComplexArray:
    """Return lower Cholesky factors, regularised by the rounding of sums as large as `scale_matrices`."""
    mean = np.einsum("...ii->...", scale_matrices).real / scale_matrices.shape[-1]
    ridge = np.where(mean > 0, SUM_ROUNDING * mean, 1.0)
    raised = np.array(matrices)
    diagonal = np.einsum("...ii->...i", raised)
    while True:
        diagonal += ridge[..., None]
        try:
            return np.asarray(np.linalg.cholesky(raised))
        except np.linalg.LinAlgError:
            ridge = 10 * ridge


def _inverse(factors: ComplexArray) -> ComplexArray:
    """Return the inverses of lower triangular matrices."""
    # a general inverse costs six times as much
    return np.stack([scipy.linalg.lapack.ztrtri(factor, lower=1)[0] for factor in factors])


def _noise_contribution(z_data: ZDomainData, normal: _Normal) -> ComplexArray:
    """Return C, the contribution to M of noise with the variances implied by the weights.

    The numerators fit a part of the noise in an equation, the leverage of its line.
    """
    n_in = z_data.frf.shape[1]
    order = normal.inverse.shape[1] - 1
    lags = _along_diagonals(normal.inverse)
    round_circle = np.zeros((len(lags), z_data.points), complex)
    round_circle[:, : order + 1] = lags[:, order:]
    round_circle[:, z_data.points - order :] = lags[:, :order]
    leverage = z_data.weight * scipy.fft.fft(round_circle)[:, : z_data.weight.shape[1]].real
    unexplained = np.clip(1 - leverage, 0.0, 1.0)
    noise_block = _toeplitz(z_data.sums((z_data.noise * unexplained[:, None]).sum(axis=0), order))
    added = np.zeros((order + 1, n_in, order + 1, n_in), complex)
    for i in range(n_in):
        added[:, i, :, i] = noise_block[i]
    return added.reshape(normal.reduced.shape)


def _along_diagonals(matrices: ComplexArray) -> ComplexArray:
    """Return the sum of every diagonal, (..., 2 n + 1), from lag -n to n."""
    size = matrices.shape[-1]
    # each row is shifted one column to the right of the row below it
    skewed = np.zeros((*matrices.shape[:-1], 2 * size), complex)
    skewed[..., :size] = matrices[..., ::-1, :]
    flat = skewed.reshape(*matrices.shape[:-2], -1)[..., :-size]
    return np.asarray(flat.reshape(*matrices.shape[:-1], 2 * size - 1).sum(axis=-2))


def _noise_level(factor: ComplexArray, added: ComplexArray) -> float:
    """Return the largest c for which `M - c C` has no negative eigenvalue, from the Cholesky factor of M."""
    inverse = _inverse(factor[None])[0]
    covariance = inverse @ added @ inverse.conj().T
    largest = float(np.linalg.eigvalsh(covariance)[-1])
    return 1 / largest if largest > 0 else 0.0

"""Poles, residues and strengths of matrix fractions."""

from collections.abc import Iterator

import numpy as np
import scipy.linalg

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.extraction.multi_mode.chart_settings import MATRIX_FRACTION
from modallab.extraction.multi_mode.global_method import Poles
from modallab.extraction.multi_mode.matrix_fraction import Fractions, ZDomainData, fit_fractions, to_z_domain


def poles_of_fractions(freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
    """Return the poles of matrix fractions in the band; parameters as `GlobalMethod`.

    Raises
    ------
    InvalidInputError
        If the lines are too few for the orders.
    """
    highest = int(orders[-1]) if len(orders) else 0
    circle = to_z_domain(frf, weight, max(highest, 1))
    usable = np.count_nonzero(circle.weight.any(axis=0))
    if (
        not highest
        or orders[0] < 1
        or MATRIX_FRACTION.lines_per_order * highest > usable
        or (np.diff(orders) < 1).any()
    ):
        raise InvalidInputError(
            f"{usable} lines do not determine polynomials of such orders",
            field="max_order",
            value=highest,
            allowed=bounds(1, int(usable // MATRIX_FRACTION.lines_per_order)),
        )
    fractions = fit_fractions(circle, orders)
    row, inverse_zero, logarithm = _stable_in_band(circle, *_inverse_zeros(fractions.denominator, orders))
    spacing = float(freq[1] - freq[0])
    rate = circle.points * spacing  # z = exp(s / rate), s from the first line on
    pole = 2j * np.pi * freq[0] + rate * logarithm
    ranked = np.lexsort((np.abs(pole), row))
    row, inverse_zero, pole = row[ranked], inverse_zero[ranked], pole[ranked]
    # dz = z ds / rate
    residue = _residues(circle, fractions, row, 1 / inverse_zero) * (rate * inverse_zero)[:, None]
    strength = _strengths(freq, residue, weight.reshape(len(freq), -1), pole)
    strength /= np.sqrt(max(fractions.noise, np.finfo(float).tiny))
    return Poles(orders, orders[row], pole, residue, strength, spacing)


def companions(denominator: ComplexArray, orders: IntArray) -> Iterator[ComplexArray]:
    """Return for each order a matrix whose eigenvalues are the 1/z where `det A(z) = 0`.

    Parameters
    ----------
    denominator
        (n_orders, n + 1, n_in, n_in), the lowest coefficient a unit matrix.
    orders
        (n_orders,) rising. A matrix is good until the next one is asked for: they share their memory.
    """
    n_in = denominator.shape[-1]
    largest = n_in * int(orders[-1])
    companion = np.eye(largest, k=-n_in, dtype=complex, order="F")  # as LAPACK has it
    top = -denominator[:, 1:].transpose(0, 2, 1, 3).reshape(len(orders), n_in, largest)
    for row, size in zip(top, (n_in * orders).tolist(), strict=True):
        companion[:n_in, :size] = row[:, :size]
        yield companion[:size, :size]


def _inverse_zeros(denominator: ComplexArray, orders: IntArray) -> tuple[IntArray, ComplexArray]:
    """Return the solutions of `det A(z) = 0`: the row of the order, and 1/z."""
    eigenvalues = [_eigenvalues(companion) for companion in companions(denominator, orders)]
    return np.repeat(np.arange(len(orders)), denominator.shape[-1] * orders), np.concatenate(eigenvalues)


def _eigenvalues(matrix: ComplexArray) -> ComplexArray:
    """Return the eigenvalues of a matrix by LAPACK zgeev, without the overhead of `numpy.linalg.eigvals`."""
    values, _, _, failed = scipy.linalg.lapack.zgeev(matrix, compute_vl=0, compute_vr=0)
    if failed:
        raise np.linalg.LinAlgError("eigenvalues did not converge")
    return np.asarray(values)


def _stable_in_band(
    z_data: ZDomainData, row: IntArray, inverse_zero: ComplexArray
) -> tuple[IntArray, ComplexArray, ComplexArray]:
    """Return stable poles with a frequency on the arc, and the logarithms of z = 1/turn."""
    stable = np.abs(inverse_zero) > 1
    row, inverse_zero = row[stable], inverse_zero[stable]
    logarithm = -np.log(inverse_zero)
    logarithm.imag %= 2 * np.pi
    inside = logarithm.imag <= 2 * np.pi * (z_data.frf.shape[2] - 1) / z_data.points
    return row[inside], inverse_zero[inside], logarithm[inside]


def _residues(z_data: ZDomainData, fractions: Fractions, row: IntArray, z: ComplexArray) -> ComplexArray:
    """Return the residues of `H(z)` at its poles, (n_poles, n_out * n_in).

    Where `A v = 0` and `u^H A = 0` the residue of `B A^-1` is `B v u^H / (u^H A' v)`.
    """
    n_orders, terms, n_in, _ = fractions.denominator.shape
    at = _AtPoles(row, z, n_orders, terms)
    if n_in > 1:
        value = at.of(fractions.denominator.reshape(n_orders, terms, -1)).reshape(-1, n_in, n_in)
        u_vectors, _, v_vectors = np.linalg.svd(value)
        u, v = u_vectors[:, :, -1].conj(), v_vectors[:, -1, :].conj()
    else:
        u = v = np.ones((len(z), 1), complex)
    rising = np.arange(terms)[:, None, None] * fractions.denominator  # z A'
    slope = at.of(rising.reshape(n_orders, terms, -1)).reshape(-1, n_in, n_in)
    steep = (u[:, :, None] * slope * v[:, None, :]).sum(axis=(1, 2)) / z
    of_all = fractions.denominator.transpose(0, 3, 1, 2).reshape(n_orders * n_in, terms * n_in)
    across = np.empty((len(z), len(fractions.numerator)), complex)
    for start in range(0, across.shape[1], MATRIX_FRACTION.frfs_in_memory):
        part = fractions.numerator[start : start + MATRIX_FRACTION.frfs_in_memory]
        n = len(part)
        numerator = (of_all @ part.reshape(-1, terms * n_in).T).reshape(n_orders, n_in * n, terms)
        value = at.of(numerator.swapaxes(1, 2))
        across[:, start : start + n] = (value.reshape(len(z), n_in, n) * v[:, :, None]).sum(axis=1)
    derivatives = across[:, :, None] * (u / steep[:, None])[:, None, :] * z_data.scale
    return np.asarray(derivatives.reshape(len(z), z_data.scale.size))


def _powers(z: ComplexArray, terms: int) -> ComplexArray:
    """Return z^0 to z^(terms - 1), (terms, n_poles)."""
    powers = np.ones((terms, len(z)), complex)
    n_known = 1
    while n_known < terms:  # twice as many each time
        powers[n_known : 2 * n_known] = powers[: terms - n_known][:n_known] * (powers[n_known - 1] * z)
        n_known *= 2
    return powers


class _AtPoles:
    """Polynomials of every order at the poles of that order, all orders at once."""

    def __init__(self, row: IntArray, z: ComplexArray, n_orders: int, terms: int) -> None:
        self._row = row
        self._place = np.arange(len(row)) - np.searchsorted(row, row)
        most = int(self._place.max(initial=-1)) + 1
        self._powers = np.zeros((n_orders, most, terms), complex)
        self._powers[row, self._place] = _powers(z, terms).T

    def of(self, coefficient: ComplexArray) -> ComplexArray:
        """Return the values, (n_poles, n), of coefficients (n_orders, terms, n)."""
        return np.asarray((self._powers @ coefficient)[self._row, self._place])


def _strengths(freq: FloatArray, residue: ComplexArray, weight: FloatArray, pole: ComplexArray) -> FloatArray:
    """Return how strong each pole's part of the FRFs is, (n_poles,), as `Poles` has it.

    The sum of `1/|i omega_k - s|^2` over endless lines is known in closed form.
    """
    step = 2 * np.pi * float(freq[1] - freq[0])
    used = np.flatnonzero(weight.any(axis=1))
    between = 2 * np.pi * (freq[used[1:]] + freq[used[:-1]]) / 2
    nearest = used[np.searchsorted(between, pole.imag)]
    decay = -pole.real
    fade = np.exp(-2 * np.pi * decay / step)
    beat = np.cos(2 * np.pi * (pole.imag / step - freq[0] / (freq[1] - freq[0])))
    total = np.pi / (decay * step) * (1 - fade**2) / (1 + fade**2 - 2 * beat * fade)
    square = weight[nearest] * (residue.real**2 + residue.imag**2)
    return np.asarray(np.sqrt(total * square.mean(axis=1)))

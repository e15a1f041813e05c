"""Weighted products of columns, summed over the lines with the weights of every FRF."""

import numpy as np
import scipy.linalg.blas

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.fit_settings import PROJECTION
from modallab.extraction.multi_mode.line_groups import LineGroups


def weighted_products(columns: ComplexArray, weight: FloatArray, *, paired_columns: bool) -> FloatArray:
    """Return `sum_k w_kj Re(conj(c_ka) c_kb)`, (n_frf, n, n).

    Parameters
    ----------
    columns
        (n_lines, n), with real coefficients.
    weight
        (n_lines, n_frf), not negative.
    paired_columns
        Whether every second column is the preceding one times i, so that half of the products suffice.
    """
    if paired_columns:
        return _hermitian_products(columns[:, ::2], weight)
    parts = np.concatenate([columns.real, columns.imag])
    return (_products_by_frf if weight.shape[1] < columns.shape[1] else _all_pairs)(parts, weight)


def grouped_products(
    columns: ComplexArray, groups: LineGroups, first_line: int, *, paired_columns: bool
) -> FloatArray:
    """Return the same as `weighted_products` for lines in groups, each summed once for all FRFs.

    Parameters
    ----------
    columns
        (n_lines, n), of lines from `first_line` on.
    groups
        Of all lines.
    """
    block = slice(first_line, first_line + len(columns))
    group = groups.group[block]
    first = np.concatenate([[0], np.flatnonzero(np.diff(group)) + 1])
    summed = columns[:, ::2] if paired_columns else columns
    number, scaled = group[first], summed * np.sqrt(groups.profile[block])[:, None]
    n, products_of = summed.shape[1], _real_and_cross_products if paired_columns else _real_products
    # real and imaginary part of a line in adjacent rows
    parts_of_groups = np.split(np.stack([scaled.real, scaled.imag], axis=1).reshape(-1, n), 2 * first[1:])
    step = max(PROJECTION.products_in_memory // columns.shape[1] ** 2, 1)
    total: FloatArray | float = 0.0
    for start in range(0, len(first), step):
        products = np.array([products_of(parts) for parts in parts_of_groups[start : start + step]])
        level = groups.level[number[start : start + step]]
        total += (level.T @ products.reshape(len(products), -1)).reshape(-1, *products.shape[1:])
    return _of_pairs(np.asarray(total)) if paired_columns else np.asarray(total)


def _real_products(parts: FloatArray) -> FloatArray:
    """Return the products (n, n) of columns whose parts are in adjacent rows (2 n_lines, n)."""
    return np.asarray(parts.T @ parts)


def _real_and_cross_products(parts: FloatArray) -> FloatArray:
    """Return `_real_products`, and the products of imaginary with real parts, (2, n, n)."""
    return np.array([parts.T @ parts, parts[1::2].T @ parts[::2]])


def _of_pairs(sums: FloatArray) -> FloatArray:
    """Return products of columns and of the columns times i, (n_frf, 2 n, 2 n), from sums (n_frf, 2, n, n).

    The sums are those of `_real_and_cross_products`.
    """
    n_frf, _, n, _ = sums.shape
    real, cross = sums[:, 0], sums[:, 1] - sums[:, 1].swapaxes(1, 2)
    products = np.empty((n_frf, n, 2, n, 2))
    products[:, :, 0, :, 0] = products[:, :, 1, :, 1] = real
    products[:, :, 0, :, 1], products[:, :, 1, :, 0] = cross, -cross
    return products.reshape(n_frf, 2 * n, 2 * n)


def _hermitian_products(columns: ComplexArray, weight: FloatArray) -> FloatArray:
    """Return the products of columns and of the columns times i, by one Hermitian product for each FRF."""
    n = columns.shape[1]
    products = np.empty((weight.shape[1], n, 2, n, 2))
    first, second = np.triu_indices(n)
    for frf_products, root in zip(products, np.sqrt(weight).T, strict=True):
        upper = scipy.linalg.blas.zherk(1.0, (columns * root[:, None]).T)[first, second]
        frf_products[first, :, second, :] = frf_products[second, :, first, :] = upper.real[
            :, None, None
        ] * np.eye(2)
        frf_products[first, 0, second, 1] = frf_products[second, 1, first, 0] = upper.imag
        frf_products[first, 1, second, 0] = frf_products[second, 0, first, 1] = -upper.imag
    return products.reshape(-1, 2 * n, 2 * n)


def _products_by_frf(parts: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the products of stacked real and imaginary parts, by one product for each FRF."""
    n = parts.shape[1]
    products = np.empty((weight.shape[1], n, n))
    first, second = np.triu_indices(n)
    for frf_products, root in zip(products, np.sqrt(np.concatenate([weight, weight])).T, strict=True):
        upper = scipy.linalg.blas.dsyrk(1.0, (parts * root[:, None]).T)[first, second]
        frf_products[first, second] = frf_products[second, first] = upper
    return products


def _all_pairs(parts: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the same by one product for all FRFs, each pair of columns formed once."""
    n, (n_lines, n_frf) = parts.shape[1], weight.shape
    first, second = np.triu_indices(n)
    half = np.zeros((n_frf, len(first)))
    real, imaginary = parts[:n_lines], parts[n_lines:]
    step = max(PROJECTION.products_in_memory // len(first), 1)
    for start in range(0, n_lines, step):
        some = slice(start, start + step)
        pairs = real[some, first] * real[some, second]
        pairs += imaginary[some, first] * imaginary[some, second]
        half += weight[some].T @ pairs
    products = np.empty((n_frf, n, n))
    products[:, first, second] = half
    products[:, second, first] = half
    return products

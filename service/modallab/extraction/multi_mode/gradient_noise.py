"""Scatter of the normal equations of a fit of all modes by the random errors of the lines."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.pole_basis import PoleBasis
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
    columns_and_slopes,
)
from modallab.extraction.preprocessing.noise_model import with_conjugate_phase


@dataclass(frozen=True, eq=False)
class GradientNoise:
    """Second moments of the sums over the lines of each DoF, over half their variance E|error|^2."""

    gradient: FloatArray
    """(n_dof, n, n) of the right-hand side of the normal equations of all parameters."""
    coefficients: FloatArray
    """(n_dof, n_columns, n_columns) of the coefficients of the columns for fixed parameters."""
    cross: FloatArray | None
    """(n_dof, n_columns, n) of both; None where they are independent."""
    unknowns: FloatArray
    """(n_dof,) part of the squared errors that the coefficients absorb, in real errors of a line."""

    @classmethod
    def of_independent_lines(cls, normal: FloatArray, linear: LinearSolution) -> Self:
        """Return the moments for lines with weights of one over their variance.

        Parameters
        ----------
        normal
            (n_dof, n, n) normal matrices of the parameters.
        linear
            Solution of the fit.
        """
        unknowns = np.full(len(normal), float(linear.coefficients.shape[1]))
        return cls(normal, linear.inverse, None, unknowns)

    @classmethod
    def of_correlated_lines(
        cls,
        lines: ScaledLines,
        basis: PoleBasis,
        parameters: FloatArray,
        linear: LinearSolution,
        influence: FloatArray,
    ) -> Self:
        """Return the moments for lines whose errors are correlated.

        Parameters
        ----------
        lines, basis, parameters, linear
            As in the fit.
        influence
            (n_dof, n_columns + n_slopes, n) influence of the sums over lines on the gradient.
        """
        products = _correlated_products(lines, basis, parameters)
        n = linear.coefficients.shape[1]
        on_gradient = products @ influence
        absorbed = linear.inverse @ products[:, :n, :n]
        return cls(
            influence.swapaxes(1, 2) @ on_gradient,
            absorbed @ linear.inverse,
            linear.inverse @ on_gradient[:, :n],
            np.asarray(np.trace(absorbed, axis1=1, axis2=2)),
        )


def _correlated_products(lines: ScaledLines, basis: PoleBasis, parameters: FloatArray) -> FloatArray:
    """Return the covariance of weighted sums of errors over lines, (n_dof, n, n), of columns and slopes."""
    mix, paired = lines.reference_mixing(basis, parameters), basis.paired_columns
    columns = columns_and_slopes(lines, basis, parameters, slice(None))
    different = np.ascontiguousarray(columns[:, :: 2 if paired else 1].T)
    correlated, by_force = lines.noise.correlated, lines.noise.force_share
    assert correlated is not None
    share = np.zeros(lines.weight.shape) if by_force is None else by_force
    products = np.zeros((lines.weight.shape[1], mix.n_frf_all, mix.n_frf_all))
    for j, frf_products in enumerate(products):
        own = np.sqrt(lines.weight[:, j] * (1 - share[:, j]))
        # noise of the force has the phase of the FRF
        common = with_conjugate_phase(np.sqrt(lines.weight[:, j] * share[:, j]), lines.response[:, j])
        for deviation in (own, common):
            if not deviation.any():
                continue
            sums = correlated.independent(different * deviation)
            hermitian = sums.conj() @ sums.T
            frf_products += _with_turned_columns(hermitian) if paired else hermitian.real
    return mix.products(products)


def _with_turned_columns(products: ComplexArray) -> FloatArray:
    """Return real products (2 n, 2 n) of columns and of the same times i from complex ones, (n, n)."""
    real, imaginary = products.real, products.imag
    rows = [np.stack([real, -imaginary], axis=-1), np.stack([imaginary, real], axis=-1)]
    return np.stack(rows, axis=1).reshape(2 * len(products), -1)

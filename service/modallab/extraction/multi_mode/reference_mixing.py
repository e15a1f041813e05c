"""Sums over lines for modes with shapes common to several references, from sums of single FRFs."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.extraction.multi_mode.pole_basis import PoleBasis


@dataclass(frozen=True, eq=False)
class ReferenceMixing:
    """Linear map between the least-squares columns of single FRFs and those of all FRFs of one DoF.

    The design matrix of a single FRF has the same few columns for every reference. The columns that all FRFs
    of a DoF share (shape entries of common modes) are linear combinations of these, and so are their sums
    over the frequency lines. The lines are therefore summed once, with the few columns of a single FRF, and
    not once for each reference with all columns.
    """

    matrices: FloatArray | None
    """(n_references, n_each, n_all) columns, then slopes; None if FRFs share nothing."""
    n_frf_all: int
    """Number of columns and slopes of one FRF."""
    n_frf_columns: int
    """Number of columns of one FRF."""
    n_dof_columns: int
    """Number of columns of all FRFs of a DoF."""

    def products(self, frf_products: FloatArray) -> FloatArray:
        """Return the normal matrices of the DoFs, (n_dof, n_all, n_all).

        Parameters
        ----------
        frf_products
            Those of the FRFs, (n_frf, n_each, n_each).
        """
        if self.matrices is None:
            return frf_products
        by_reference = frf_products.reshape(-1, *self.matrices.shape[:2], frf_products.shape[2])
        total = np.zeros((len(by_reference), self.matrices.shape[2], self.matrices.shape[2]))
        for k, mixing_matrix in enumerate(self.matrices):
            nonzero = np.flatnonzero(mixing_matrix.any(axis=0))  # columns that belong to this reference
            total[:, nonzero[:, None], nonzero] += (
                mixing_matrix[:, nonzero].T @ by_reference[:, k] @ mixing_matrix[:, nonzero]
            )
        return total

    def sums(self, frf_sums: FloatArray) -> FloatArray:
        """Return the right-hand sides of the DoFs (n_dof, n_all) from those of the FRFs (n_frf, n_each).

        Both may have the columns only, without the slopes.
        """
        if self.matrices is None:
            return frf_sums
        columns = frf_sums.shape[1] == self.n_frf_columns
        mixing_matrix = (
            self.matrices[:, : self.n_frf_columns, : self.n_dof_columns] if columns else self.matrices
        )
        by_reference = frf_sums.reshape(-1, len(mixing_matrix), frf_sums.shape[1])
        return np.asarray(np.einsum("jkl,klc->jc", by_reference, mixing_matrix, optimize=True))

    def coefficients(self, of_all: FloatArray) -> FloatArray:
        """Return the coefficients of every FRF (n_frf, n_each) from those of the DoFs (n_dof, n_all)."""
        if self.matrices is None:
            return of_all
        columns = self.matrices[:, : self.n_frf_columns, : self.n_dof_columns]
        return np.asarray(
            np.einsum("klc,jc->jkl", columns, of_all, optimize=True).reshape(-1, self.n_frf_columns)
        )

    def influence(self, of_all: FloatArray) -> list[FloatArray]:
        """Return the rows of each reference, (n_dof, n_each, n), from those of the DoFs (n_dof, n_all, n)."""
        return (
            [of_all]
            if self.matrices is None
            else [np.asarray(mixing_matrix @ of_all) for mixing_matrix in self.matrices]
        )


def reference_mixing(basis: PoleBasis, parameters: FloatArray, n_residuals: int) -> ReferenceMixing:
    """Return the linear map for all references; residuals belong to a single reference.

    Parameters
    ----------
    n_residuals
        Number of residual columns of an FRF, beside those of the modes.
    """
    n_modes, mixing = len(parameters), basis.mixing(parameters)
    n_each = 2 * n_modes + n_residuals
    if mixing is None:
        return ReferenceMixing(None, n_each + n_modes * basis.slope_weights.shape[2], n_each, n_each)
    n_ref, _, n_own, n_slopes = mixing.shape
    n_all = 2 * n_modes + n_ref * n_residuals
    mixing_matrix = np.zeros((n_ref, n_each + n_modes * (n_own - 2), n_all + n_modes * (n_slopes - 2)))
    modes, residuals = np.arange(n_modes), np.arange(n_residuals)
    rows = np.concatenate([_of_modes(modes, 2, 0), _of_modes(modes, n_own - 2, n_each)], axis=1)
    columns = np.concatenate([_of_modes(modes, 2, 0), _of_modes(modes, n_slopes - 2, n_all)], axis=1)
    for k in range(n_ref):
        mixing_matrix[k, rows[:, :, None], columns[:, None, :]] = mixing[k]
        mixing_matrix[k, 2 * n_modes + residuals, 2 * n_modes + k * n_residuals + residuals] = 1.0
    return ReferenceMixing(mixing_matrix, mixing_matrix.shape[1], n_each, n_all)


def _of_modes(modes: IntArray, n: int, offset: int) -> IntArray:
    """Return the indices of the n columns of each mode, (n_modes, n)."""
    return np.asarray(offset + n * modes[:, None] + np.arange(n))

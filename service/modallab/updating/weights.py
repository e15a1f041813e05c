"""Weights of measured eigenvalues and shapes, in one block for each mode."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.settings import WEIGHTS
from modallab.updating.target import TargetModes


@dataclass(frozen=True, eq=False)
class Weights:
    """Standard errors of rows, and their blocks: an eigenvalue is in one block with its shape.

    An eigenvalue in a block of its own would get a large variance wherever the model misses it.
    """

    units: FloatArray  # (n_rows,) standard errors of balanced rows
    block: IntArray  # (n_rows,) index of the mode of a row
    floors: FloatArray  # (n_blocks,) least standard deviation, in these units
    stated: bool

    @classmethod
    def of(cls, target: TargetModes) -> "Weights":
        """Return weights by stated errors, or by usual ones where none are stated."""
        n_dofs, n_modes = target.shapes.shape
        size = np.sqrt((np.abs(target.shapes) ** 2).mean(axis=0))
        sizes = np.concatenate([np.ones(n_modes), np.tile(size, n_dofs)])
        block, n_components = np.tile(np.arange(n_modes), 1 + n_dofs), 2 if target.damped else 1
        default_units = np.where(np.arange(len(sizes)) < n_modes, 1.0, WEIGHTS.shape_error_ratio) * sizes
        sizes, default_units, block = (
            np.tile(array, n_components) for array in (sizes, default_units, block)
        )
        if target.errors is None:
            return cls(default_units, block, np.full(n_modes, WEIGHTS.min_relative_error), False)
        return cls(
            np.maximum(target.errors, WEIGHTS.min_relative_error * sizes), block, np.ones(n_modes), True
        )

    def rows(self, fit: ModalResiduals, state: ModelState) -> tuple[FloatArray, FloatArray]:
        """Return derivatives (n_rows, n_params) and residuals (n_rows,), in units of the errors."""
        unit = state.size * self.units
        return fit.sensitivity(state) / unit[:, None], state.difference / unit

    def misfit_note(self, block_variances: FloatArray) -> str:
        """Return a note on modes whose misfit exceeds their errors; empty if there is none.

        Parameters
        ----------
        block_variances
            (n_blocks,) mean square of their weighted rows.
        """
        outliers = np.flatnonzero(
            np.sqrt(block_variances)
            > (WEIGHTS.max_deviations if self.stated else WEIGHTS.max_unstated_misfit)
        )
        if not outliers.size:
            return ""
        modes = ", ".join(str(mode + 1) for mode in outliers)
        return f"; measured mode{'s' * (outliers.size > 1)} {modes} missed by more than errors explain"

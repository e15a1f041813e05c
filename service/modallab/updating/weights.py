"""Which measured numbers are alike in their errors, and how large these are at least."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.settings import WEIGHTS
from modallab.updating.target import TargetModes


@dataclass(frozen=True, eq=False)
class Weights:
    """Rows in units of their errors, and their blocks: an eigenvalue is in one block with its shape.

    An eigenvalue with no shape beside it would count as badly measured wherever the model misses it.
    """

    units: FloatArray  # (n_rows,) that balanced rows are divided by
    block: IntArray  # (n_rows,) which mode a row is of, counted from 0
    floors: FloatArray  # (n_blocks,) of a row in its unit
    stated: bool

    @classmethod
    def of(cls, target: TargetModes) -> "Weights":
        """Return the weights of measured modes: by stated errors, or by usual ones where none are stated."""
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
        """Return derivatives (n_rows, n_params) and what the model misses (n_rows,), in these units."""
        unit = state.size * self.units
        return fit.sensitivity(state) / unit[:, None], state.difference / unit

    def misfit_note(self, block_variances: FloatArray) -> str:
        """Return which modes the model misses by more than errors explain, as words to add; nothing if none.

        Parameters
        ----------
        block_variances
            (n_blocks,) mean square of their rows.
        """
        outliers = np.flatnonzero(
            np.sqrt(block_variances)
            > (WEIGHTS.max_deviations if self.stated else WEIGHTS.max_unstated_misfit)
        )
        if not outliers.size:
            return ""
        modes = ", ".join(str(mode + 1) for mode in outliers)
        return f"; measured mode{'s' * (outliers.size > 1)} {modes} missed by more than errors explain"

"""Which measured numbers are alike in their errors, and how large these are at least."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.updating.fit import Fit, State
from modallab.updating.target import TargetModes

EXACT = 1e-7  # of a row's size: what eigenvalues of a good model scatter by, however well they were measured
FEW = 5  # sensors below which one shape has too few rows to tell its error by


@dataclass(frozen=True, eq=False)
class Weights:
    """Rows in units of their stated errors, or balanced where none are stated, and their blocks."""

    units: FloatArray  # (n_rows,) that balanced rows are divided by
    block: IntArray  # (n_rows,) all eigenvalues are one block, and every shape
    floors: FloatArray  # (n_blocks,) of a row in its unit

    @classmethod
    def of(cls, target: TargetModes) -> "Weights":
        """Return the weights of measured modes."""
        block = _blocks(target)
        sizes = np.concatenate([np.ones(len(target.squares)), np.abs(target.shapes).ravel()])
        sizes = np.tile(sizes, 2) if target.damped else sizes
        n = int(block.max()) + 1
        mean = np.sqrt(np.bincount(block, sizes**2, n) / np.bincount(block, minlength=n))
        if target.errors is None:
            return cls(np.ones(len(sizes)), block, EXACT * mean)
        return cls(np.maximum(target.errors, EXACT * mean[block]), block, np.ones(n))

    def rows(self, fit: Fit, state: State) -> tuple[FloatArray, FloatArray]:
        """Return derivatives (n_rows, n_params) and what the model misses (n_rows,), in these units."""
        unit = state.size * self.units
        return fit.sensitivity(state) / unit[:, None], state.difference / unit

    def scales(self, remaining: FloatArray) -> FloatArray:
        """Return the mean square of each block's rows (n_rows,), no less than the floors'."""
        n = len(self.floors)
        square = np.bincount(self.block, remaining**2, n) / np.bincount(self.block, minlength=n)
        return np.asarray(np.maximum(square, self.floors**2))


def _blocks(target: TargetModes) -> IntArray:
    n_dofs, n_modes = target.shapes.shape
    shapes = 1 + np.arange(n_modes) if n_dofs >= FEW else np.ones(n_modes, int)
    block = np.concatenate([np.zeros(n_modes, int), np.tile(shapes, n_dofs)])
    return np.tile(block, 2) if target.damped else block

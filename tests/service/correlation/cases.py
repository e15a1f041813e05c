"""Shapes and modal models that tests of correlation share."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode

POINTS = tuple(Dof(node, "Y") for node in range(1, 9))


def shapes(seed: int, n_modes: int = 4) -> ComplexArray:
    """Return unlike complex shapes, (8, n_modes)."""
    rng = np.random.default_rng(seed)
    values: ComplexArray = rng.standard_normal((8, n_modes)) + 0.1j * rng.standard_normal((8, n_modes))
    return values


def model(values: ComplexArray, dofs: tuple[Dof, ...] = POINTS, start: float = 10.0) -> ModalModel:
    """Return modes of these shapes at 10, 20, 30 Hz and so on."""
    modes = tuple(Mode(start * (i + 1), 0.01, column) for i, column in enumerate(values.T))
    return ModalModel(modes, dofs)

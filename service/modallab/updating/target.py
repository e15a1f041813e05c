"""Measured modes as real modes of an undamped model can be held against them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel


@dataclass(frozen=True, eq=False)
class RealModes:
    """Undamped modes at some DoFs, and how far off they may be."""

    squares: FloatArray  # (n_modes,) omega_r^2, rad^2/s^2
    shapes: FloatArray  # (n_dof, n_modes)
    dofs: tuple[Dof, ...]
    mass_normalised: bool
    errors: FloatArray | None  # (n_modes * (1 + n_dof),) standard errors, eigenvalues over themselves first

    def __post_init__(self) -> None:
        n = len(self.squares)
        object.__setattr__(self, "squares", frozen(self.squares, float, (None,), name="frequencies"))
        object.__setattr__(self, "shapes", frozen(self.shapes, float, (len(self.dofs), n), name="shapes"))
        if self.errors is not None:
            size = n * (1 + len(self.dofs))
            object.__setattr__(self, "errors", frozen(self.errors, float, (size,), name="standard_errors"))

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.asarray(np.sqrt(self.squares) / (2 * np.pi))


def as_real(shapes: ComplexArray) -> FloatArray:
    """Return the real part of shapes (n_dof, n_modes), each turned first to be as real as it can be."""
    turn = np.exp(-0.5j * np.angle((shapes**2).sum(axis=0)))
    return np.asarray((shapes * turn).real)


def real_modes(target: ModalModel) -> RealModes:
    """Return the real modes nearest to measured ones.

    Raises
    ------
    InvalidInputError
        If there is no mode or DoF, a frequency is not above zero, or a shape is zero.
    """
    if not target.modes or not target.dofs:
        raise InvalidInputError("the modal model is empty", field="modal_model", value=0, allowed=">= 1 mode")
    frequencies = target.frequencies
    if not (np.isfinite(frequencies) & (frequencies > 0)).all():
        raise InvalidInputError(
            "elastic modes have frequencies above zero",
            field="frequencies",
            value=float(frequencies.min()),
            allowed="> 0 Hz",
        )
    shapes = as_real(target.shapes)
    still = np.flatnonzero(~shapes.any(axis=0))
    if still.size:
        raise InvalidInputError("a shape is zero", field="shapes", value=int(still[0]) + 1, allowed="motion")
    return RealModes(
        squares=(2 * np.pi * frequencies) ** 2,
        shapes=shapes,
        dofs=target.dofs,
        mass_normalised=target.normalisation == "mass",
        errors=_errors(target),
    )


def _errors(target: ModalModel) -> FloatArray | None:
    """Return the standard errors of all rows, None unless the modal model knows every one.

    Those of shapes without a scale are in no unit that a row has.
    """
    if target.normalisation != "mass":
        return None
    eigenvalues, shapes = [], []
    for mode in target.modes:
        if "frequency" not in mode.standard_errors or mode.shape_errors is None:
            return None
        eigenvalues.append(2 * mode.standard_errors["frequency"] / mode.frequency)
        shapes.append(mode.shape_errors)
    return np.concatenate([np.array(eigenvalues), np.stack(shapes, axis=1).ravel()])

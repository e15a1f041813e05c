"""Basis functions of one mode for structural and viscous damping, and their derivatives."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.options import Damping


class PoleBasis(Protocol):
    """A law of damping. A mode has two real parameters or more, and two real coefficients in each response.

    Everything is complex with real coefficients, so that pairs of conjugate poles are linear too.
    """

    @property
    def paired_columns(self) -> bool:
        """Whether of columns, and of slopes, every other one is the one before times i."""
        ...

    @property
    def slope_weights(self) -> FloatArray:
        """(2 coefficients, n_parameters, n_slopes): how each coefficient weighs the slopes' columns."""
        ...

    def at(self, order: IntArray) -> "PoleBasis":
        """Return the basis for modes in another order."""
        ...

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return (n_modes, 2): omega_r^2, and what the damping adds to it."""
        ...

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the loss factors (n_modes,) and derivatives by the first two parameters (n_modes, 2)."""
        ...

    def columns(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, 2), those of the FRFs of one reference."""
        ...

    def slopes(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, n_own), of which the derivatives by the parameters are made."""
        ...

    def mixing(self, parameters: FloatArray) -> FloatArray | None:
        """Return what a mode's columns and slopes are made of at each reference; None: of themselves.

        (n_references, n_modes, 2 + n_own, 2 + n_slopes), of the columns and slopes that one reference has.
        """
        ...

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, n_references, 2, 2): parts of a modal constant per coefficient."""
        ...

    def constant_slopes(self, parameters: FloatArray) -> FloatArray | None:
        """Return its derivatives, (n_modes, n_references, n_parameters, 2, 2); None: they do not count."""
        ...


class ModelledPoleBasis(PoleBasis, Protocol):
    """A law of damping by itself, each FRF with coefficients of its own."""

    def constant_by_pole(self, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `constant`, (n_modes, 2 parameters, 2, 2)."""
        ...


@dataclass(frozen=True)
class StructuralPoleBasis:
    """`A/(lambda_r - omega^2)`, complex A; parameters are the parts of `lambda_r`."""

    @property
    def paired_columns(self) -> bool:
        """True."""
        return True

    @property
    def slope_weights(self) -> FloatArray:
        """(2, 2, 2)."""
        return np.array([[[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [-1.0, 0.0]]])

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return (n_modes, 2)."""
        return np.stack([eigenvalue.real, eigenvalue.imag], axis=1)

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (n_modes,) and (n_modes, 2)."""
        stiffness, damping = parameters.T
        return damping / stiffness, np.stack([-damping / stiffness**2, 1 / stiffness], axis=1)

    def columns(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, 2)."""
        pole = 1 / (parameters @ [1, 1j] - omega[:, None] ** 2)
        return np.stack([pole, 1j * pole], axis=2)

    def slopes(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, 2)."""
        slope = -1 / (parameters @ [1, 1j] - omega[:, None] ** 2) ** 2
        return np.stack([slope, 1j * slope], axis=2)

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, 1, 2, 2)."""
        return np.tile(np.eye(2), (len(parameters), 1, 1, 1))

    def at(self, order: IntArray) -> Self:
        """Return the same: no mode is held apart."""
        return self

    def mixing(self, parameters: FloatArray) -> None:
        """Return None: each FRF has coefficients of its own."""
        return

    def constant_slopes(self, parameters: FloatArray) -> None:
        """Return None: a modal constant hardly depends on the pole."""
        return

    def constant_by_pole(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, 2, 2, 2)."""
        return np.zeros((len(parameters), 2, 2, 2))


@dataclass(frozen=True)
class ViscousPoleBasis:
    """`A/(i omega - s) + conj(A)/(i omega - conj(s))` over one denominator: `(a + i omega b)/D`.

    `D = omega_r^2 - omega^2 + i omega d`, parameters omega_r^2 and `d = 2 zeta_r omega_r = eta_r omega_r`.
    The modal constant is `a + s b`, `s - conj(s)` times the residue: of a mode that is real, the a of `a/D`.
    """

    @property
    def paired_columns(self) -> bool:
        """False."""
        return False

    @property
    def slope_weights(self) -> FloatArray:
        """(2, 2, 3)."""
        return np.array([[[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], [[0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]])

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return (n_modes, 2)."""
        omega = np.sqrt(eigenvalue.real)
        return np.stack([eigenvalue.real, eigenvalue.imag / omega], axis=1)

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (n_modes,) and (n_modes, 2)."""
        stiffness, damping = parameters.T
        omega = np.sqrt(stiffness)
        return damping / omega, np.stack([-damping / (2 * stiffness * omega), 1 / omega], axis=1)

    def columns(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, 2)."""
        pole = 1 / self._denominator(omega, parameters)
        return np.stack([pole, 1j * omega[:, None] * pole], axis=2)

    def slopes(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return (n_lines, n_modes, 3)."""
        squared = 1 / self._denominator(omega, parameters) ** 2
        along = 1j * omega[:, None]
        return np.stack([squared, along * squared, along**2 * squared], axis=2)

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, 1, 2, 2)."""
        stiffness, damping = parameters.T
        across = np.sqrt(np.maximum(stiffness - damping**2 / 4, 0.0))
        unit, zeros = np.ones_like(stiffness), np.zeros_like(stiffness)
        return np.stack([np.stack([unit, -damping / 2], 1), np.stack([zeros, across], 1)], axis=1)[:, None]

    def at(self, order: IntArray) -> Self:
        """Return the same: no mode is held apart."""
        return self

    def mixing(self, parameters: FloatArray) -> None:
        """Return None: each FRF has coefficients of its own."""
        return

    def constant_slopes(self, parameters: FloatArray) -> None:
        """Return None: a modal constant hardly depends on the pole."""
        return

    def constant_by_pole(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, 2, 2, 2)."""
        stiffness, damping = parameters.T
        across = np.sqrt(np.maximum(stiffness - damping**2 / 4, np.finfo(float).tiny))
        slopes = np.zeros((len(parameters), 2, 2, 2))
        slopes[:, 1, 0, 1] = -0.5
        slopes[:, 0, 1, 1], slopes[:, 1, 1, 1] = 1 / (2 * across), -damping / (4 * across)
        return slopes

    def _denominator(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        stiffness, damping = parameters.T
        return np.asarray(stiffness - omega[:, None] ** 2 + 1j * omega[:, None] * damping)


BASES: Mapping[Damping, ModelledPoleBasis] = {
    Damping.STRUCTURAL: StructuralPoleBasis(),
    Damping.VISCOUS: ViscousPoleBasis(),
}


def residual_columns(omega: FloatArray, fixed_poles: tuple[float, ...]) -> ComplexArray:
    """Return (n_lines, 4 + 2 n_beyond): a constant, `-1/omega^2`, poles held beyond the range.

    Each for real and imaginary part.

    Parameters
    ----------
    fixed_poles
        Where these poles are: a mode not far above the range is no constant in it.
    """
    real = [np.ones(len(omega)), -1 / omega**2, *(1 / (pole**2 - omega**2) for pole in fixed_poles)]
    return np.stack([part * column for column in real for part in (1, 1j)], axis=1)


def all_columns(
    basis: PoleBasis, omega: FloatArray, parameters: FloatArray, fixed_poles: tuple[float, ...]
) -> ComplexArray:
    """Return (n_lines, 2 n_modes + 4 + 2 n_beyond), mode by mode, then the residuals."""
    columns = basis.columns(omega, parameters).reshape(len(omega), -1)
    return np.concatenate([columns, residual_columns(omega, fixed_poles)], axis=1)


def all_slopes(basis: PoleBasis, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
    """Return (n_lines, n_modes n_own), mode by mode."""
    return basis.slopes(omega, parameters).reshape(len(omega), -1)

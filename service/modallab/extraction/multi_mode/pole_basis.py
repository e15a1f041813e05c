"""Basis functions of one mode for structural and viscous damping, and their derivatives."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.fit_settings import MODAL_FIT
from modallab.extraction.options import Damping


class PoleBasis(Protocol):
    """Damping model as basis functions of a mode, with their derivatives by the mode's parameters.

    A mode has two real parameters or more, and two real coefficients in each response. The basis functions
    are complex and the coefficients real, so that pairs of conjugate poles are linear too. In shapes,
    `n_slope_columns` is the number of slope columns of one reference, `n_slopes` that of all references.
    """

    @property
    def paired_columns(self) -> bool:
        """Whether every second column, and every second slope, is the preceding one times i."""
        ...

    @property
    def slope_weights(self) -> FloatArray:
        """Weights of the slope columns in derivatives, (2 coefficients, n_parameters, n_slopes)."""
        ...

    def at(self, order: IntArray) -> "PoleBasis":
        """Return the basis of the same modes in the given order, (n_modes,)."""
        ...

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return omega_r^2 and the damping parameter of each mode, (n_modes, 2)."""
        ...

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the loss factors (n_modes,) and derivatives by the first two parameters (n_modes, 2)."""
        ...

    def largest_damping(self, parameters: FloatArray) -> FloatArray:
        """Return the largest damping parameters at which the modes have modal constants, (n_modes,)."""
        ...

    def columns(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return the basis functions of the FRFs of one reference, (n_lines, n_modes, 2)."""
        ...

    def slopes(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return the slope columns, (n_lines, n_modes, n_slope_columns), from which derivatives follow."""
        ...

    def mixing(self, parameters: FloatArray) -> FloatArray | None:
        """Return the matrices from columns and slopes of one reference to those of all references.

        (n_references, n_modes, 2 + n_slope_columns, 2 + n_slopes); None if each FRF has its own coefficients.
        """
        ...

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return parts of the modal constant per coefficient, (n_modes, n_references, 2, 2)."""
        ...

    def constant_slopes(self, parameters: FloatArray) -> FloatArray | None:
        """Return derivatives of `constant`, (n_modes, n_references, n_parameters, 2, 2), or None."""
        ...


class ModelledPoleBasis(PoleBasis, Protocol):
    """Damping model for FRFs with independent coefficients."""

    def constant_by_pole(self, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `constant`, (n_modes, 2 parameters, 2, 2)."""
        ...


@dataclass(frozen=True)
class StructuralPoleBasis:
    """Structural damping, `A/(lambda_r - omega^2)` with complex A.

    The parameters are real and imaginary part of `lambda_r`.
    """

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

    def largest_damping(self, parameters: FloatArray) -> FloatArray:
        """Return infinity, (n_modes,)."""
        return np.full(len(parameters), np.inf)

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
        """Return the same basis, which has no data of single modes."""
        return self

    def mixing(self, parameters: FloatArray) -> None:
        """Return None, because each FRF has its own coefficients."""
        return

    def constant_slopes(self, parameters: FloatArray) -> None:
        """Return None, because a modal constant hardly depends on the pole."""
        return

    def constant_by_pole(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, 2, 2, 2)."""
        return np.zeros((len(parameters), 2, 2, 2))


@dataclass(frozen=True)
class ViscousPoleBasis:
    """Viscous damping, `A/(i omega - s) + conj(A)/(i omega - conj(s))` as the fraction `(a + i omega b)/D`.

    `D = omega_r^2 - omega^2 + i omega d`, parameters omega_r^2 and `d = 2 zeta_r omega_r = eta_r omega_r`.
    The modal constant is `a + s b`, that is `s - conj(s)` times the residue; for a real mode it is a, with
    b = 0.
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

    def largest_damping(self, parameters: FloatArray) -> FloatArray:
        """Return a value below critical damping, (n_modes,): from there on a pole is real."""
        return np.asarray(MODAL_FIT.largest_loss_factor * np.sqrt(parameters[:, 0]))

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
        """Return the same basis, which has no data of single modes."""
        return self

    def mixing(self, parameters: FloatArray) -> None:
        """Return None, because each FRF has its own coefficients."""
        return

    def constant_slopes(self, parameters: FloatArray) -> None:
        """Return None, because a modal constant hardly depends on the pole."""
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
    """Return the columns of the residual terms, (n_lines, 4 + 2 n_fixed), for real and imaginary part each.

    The terms are a constant, `-1/omega^2`, and poles fixed above the range.

    Parameters
    ----------
    fixed_poles
        Positions of these poles, in the unit of `omega`. They represent modes slightly above the range,
        whose contribution is not constant over it.
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
    """Return the slope columns of all modes, (n_lines, n_modes n_slope_columns), mode by mode."""
    return basis.slopes(omega, parameters).reshape(len(omega), -1)

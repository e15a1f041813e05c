"""Modes of several references: one shape and its participation factors."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.pole_basis import BASES, ModelledPoleBasis
from modallab.extraction.options import Damping

POLE_PARAMETERS = 2  # pole parameters of a mode; its further parameters are participation factors
QUARTER_ROTATION = np.array([[0.0, -1.0], [1.0, 0.0]])  # multiplication by i of (real, imaginary) part


@dataclass(frozen=True, eq=False)
class SharedShapeBasis:
    """Modal constants of rank one, `A_jk = psi_j L_k`, with shape psi and participation factors L.

    The parameters are those of the damping model, then real and imaginary part of all participation factors
    except one. That factor, at the reference `pivot`, is fixed at 1 and defines the scale of the shape.
    """

    damping: Damping
    pivot: IntArray
    """(n_modes,) index of the reference with participation factor 1."""
    n_references: int

    @property
    def paired_columns(self) -> bool:
        """Whether every second column is the preceding one times i, as in the damping model."""
        return self._damping_basis.paired_columns

    @property
    def slope_weights(self) -> FloatArray:
        """Weights of the slope columns, (2, n_parameters, n_slopes)."""
        n_free = self.n_references - 1
        turn = np.zeros((2, POLE_PARAMETERS + 2 * n_free, 4 + 2 * n_free))
        for c in (0, 1):
            turn[c, 0, c] = turn[c, 1, 2 + c] = 1.0
        real, imaginary = POLE_PARAMETERS + 2 * np.arange(n_free), POLE_PARAMETERS + 1 + 2 * np.arange(n_free)
        first, second = 4 + 2 * np.arange(n_free), 5 + 2 * np.arange(n_free)
        turn[0, real, first] = turn[1, real, second] = turn[0, imaginary, second] = 1.0
        turn[1, imaginary, first] = -1.0
        return turn

    @property
    def _damping_basis(self) -> ModelledPoleBasis:
        return BASES[self.damping]

    @property
    def _free(self) -> IntArray:
        """Indices of the references with free participation factors, (n_modes, n_references - 1)."""
        references = np.broadcast_to(np.arange(self.n_references), (len(self.pivot), self.n_references))
        return np.asarray(references[references != self.pivot[:, None]].reshape(len(self.pivot), -1))

    def start(self, parameters: FloatArray, participation: ComplexArray) -> FloatArray:
        """Return the parameters, (n_modes, n_parameters), from pole parameters and participation factors."""
        normalised = participation / np.take_along_axis(participation, self.pivot[:, None], axis=1)
        free = np.take_along_axis(normalised, self._free, axis=1)
        parts = np.stack([free.real, free.imag], axis=2).reshape(len(parameters), -1)
        return np.concatenate([parameters, parts], axis=1)

    def participation(self, parameters: FloatArray) -> ComplexArray:
        """Return the participation factors of every mode, (n_modes, n_references)."""
        reach = np.ones((len(parameters), self.n_references), complex)
        free = parameters[:, POLE_PARAMETERS::2] + 1j * parameters[:, POLE_PARAMETERS + 1 :: 2]
        np.put_along_axis(reach, self._free, free, axis=1)
        return reach

    def at(self, order: IntArray) -> "SharedShapeBasis":
        """Return the basis of the same modes in the given order, (n_modes,)."""
        return replace(self, pivot=self.pivot[order])

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return the pole parameters of the damping model, (n_modes, 2)."""
        return self._damping_basis.parameters(eigenvalue)

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the loss factors (n_modes,) and derivatives by the pole parameters, (n_modes, 2)."""
        return self._damping_basis.loss_factor(parameters[:, :POLE_PARAMETERS])

    def largest_damping(self, parameters: FloatArray) -> FloatArray:
        """Return the largest damping parameters of the damping model, (n_modes,)."""
        return self._damping_basis.largest_damping(parameters[:, :POLE_PARAMETERS])

    def columns(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return the basis functions of the damping model, (n_lines, n_modes, 2)."""
        return self._damping_basis.columns(omega, parameters[:, :POLE_PARAMETERS])

    def slopes(self, omega: FloatArray, parameters: FloatArray) -> ComplexArray:
        """Return the slope columns of the damping model, (n_lines, n_modes, n_slope_columns)."""
        return self._damping_basis.slopes(omega, parameters[:, :POLE_PARAMETERS])

    def mixing(self, parameters: FloatArray) -> FloatArray:
        """Return the mixing matrices, (n_references, n_modes, 2 + n_slope_columns, 2 + n_slopes).

        The modal constants of a reference are `psi L`: a rotation and scaling of real and imaginary part of
        psi. The coefficients follow by the inverse of the damping model's `constant`. Derivatives by
        the pole parameters contain derivatives of both; derivatives by a participation factor are the
        columns at its reference and zero at all others.
        """
        law, n_own = parameters[:, :POLE_PARAMETERS], self._damping_basis.slope_weights.shape[2]
        unit = np.linalg.inv(self._damping_basis.constant(law)[:, 0])  # (n_modes, coefficient, part)
        reach = self.constant(parameters).swapaxes(0, 1)  # (n_references, n_modes, part, part of psi)
        shape = (self.n_references, len(parameters), 2 + n_own, 2 + self.slope_weights.shape[2])
        mixing = np.zeros(shape)
        mixing[:, :, :2, :2] = unit @ reach
        for p in range(POLE_PARAMETERS):
            of_law = np.zeros((len(parameters), 2 + n_own, 2))
            of_law[:, :2] = -unit @ self._damping_basis.constant_by_pole(law)[:, p] @ unit
            of_law[:, 2:] = self._damping_basis.slope_weights[:, p].T @ unit
            mixing[:, :, :, 2 + 2 * p : 4 + 2 * p] = of_law @ reach
        modes = np.arange(len(parameters))
        for n, free in enumerate(self._free.T):
            mixing[free, modes, :2, 6 + 2 * n : 8 + 2 * n] = unit
        return mixing

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return real and imaginary part of `psi L` per part of psi, (n_modes, n_references, 2, 2)."""
        reach = self.participation(parameters)[..., None, None]
        return np.asarray(reach.real * np.eye(2) + reach.imag * QUARTER_ROTATION)

    def constant_slopes(self, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `constant`, (n_modes, n_references, n_parameters, 2, 2)."""
        n_modes, n_parameters = parameters.shape
        slopes = np.zeros((n_modes, self.n_references, n_parameters, 2, 2))
        modes, free = np.arange(n_modes)[:, None], np.arange(self.n_references - 1)
        slopes[modes, self._free, POLE_PARAMETERS + 2 * free] = np.eye(2)
        slopes[modes, self._free, POLE_PARAMETERS + 1 + 2 * free] = QUARTER_ROTATION
        return slopes

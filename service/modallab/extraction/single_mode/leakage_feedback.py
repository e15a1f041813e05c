"""Feedback of a mode's error on itself through the leakage correction of its lines."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.settings import FEEDBACK


@dataclass(frozen=True, eq=False)
class LeakageFeedback:
    """Sensitivity of a fitted mode to the mode by which its lines were corrected.

    J is the derivative of the fitted eigenvalue with respect to the one used in the correction. An error g of
    a fit to fixed lines becomes `(1 - J)^-1 g` when both agree. If J is near 1, they agree for any mode, and
    the lines hardly determine it.
    """

    gain: FloatArray
    """(n_modes, n_frf, 2, 2) (1 - J)^-1, for real and imaginary part of the eigenvalue."""
    constant: ComplexArray
    """(n_modes, n_frf, 2) 1/kg over (rad/s)^2, derivative of the modal constant with respect to the
    eigenvalue."""
    remainder: ComplexArray
    """(n_modes, n_frf) (rad/s)^2, change of the eigenvalue by further iterations."""

    @property
    def strength(self) -> FloatArray:
        """(n_modes, n_frf) largest factor by which an error grows or shrinks; 1 without feedback."""
        size = np.linalg.svd(self.gain, compute_uv=False)
        return np.asarray(np.maximum(size[..., 0], 1 / size[..., 1]))

    def converged_covariance(self, covariance: FloatArray) -> FloatArray:
        """Return the covariance of modes that agree with the lines they corrected, (n_modes, n_frf, 4, 4).

        Parameters
        ----------
        covariance
            (n_modes, n_frf, 4, 4) of real and imaginary part of eigenvalue and modal constant, for fits to
            fixed lines.
        """
        constant_gain = np.stack([self.constant.real, self.constant.imag], axis=2) @ self.gain
        jacobian = np.zeros_like(covariance)
        jacobian[..., :2, :2], jacobian[..., 2:, :2] = self.gain, constant_gain
        jacobian[..., 2:, 2:] = np.eye(2)
        return np.asarray(jacobian @ covariance @ jacobian.swapaxes(-1, -2))


def feedback(
    refit: Callable[[ComplexArray], tuple[ComplexArray, ComplexArray]], eigenvalue: ComplexArray
) -> LeakageFeedback:
    """Return the feedback of modes through the correction of their lines, from difference quotients.

    Parameters
    ----------
    refit
        Maps eigenvalues used in the correction, (n_modes, n_frf) (rad/s)^2, to eigenvalues and modal
        constants, 1/kg, fitted to the corrected lines.
    eigenvalue
        (n_modes, n_frf) converged values, (rad/s)^2.
    """
    step = FEEDBACK.step * np.maximum(
        np.abs(eigenvalue.imag), FEEDBACK.smallest_relative_step * np.abs(eigenvalue)
    )
    fitted, constant = refit(eigenvalue)
    perturbed = [refit(eigenvalue + part * step) for part in (1, 1j)]
    slope = np.stack([(refitted - fitted) / step for refitted, _ in perturbed], axis=2)
    constant_slope = np.stack([(refitted - constant) / step for _, refitted in perturbed], axis=2)
    gain = _inverse(np.eye(2) - np.stack([slope.real, slope.imag], axis=2))
    difference = fitted - eigenvalue
    remainder = np.einsum("mjpq,mjq->mjp", gain, np.stack([difference.real, difference.imag], axis=2))
    return LeakageFeedback(gain, constant_slope, np.asarray(remainder[..., 0] + 1j * remainder[..., 1]))


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return pseudo-inverses, (..., 2, 2), with singular values of at least the setting."""
    u, singular_values, vh = np.linalg.svd(matrix)
    return np.asarray(
        (vh.swapaxes(-1, -2) / np.maximum(singular_values, FEEDBACK.smallest_singular_value)[..., None, :])
        @ u.swapaxes(-1, -2)
    )

"""What an error does to a mode by which the lines that it is fitted to are themselves freed of leakage."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray

STEP = 0.03  # of a bandwidth: the slope's own curvature and rounding both stay far below it
LEAST = 0.02  # of 1 - J: what lines hardly tell gets a large but finite error


@dataclass(frozen=True, eq=False)
class LeakageFeedback:
    """How the mode fitted to corrected lines follows the mode that they were corrected by.

    With J the slope of the fitted eigenvalue by the one it was corrected by, an error g of a fit to lines
    that are held is one of `(1 - J)^-1 g` once the two agree. Where J comes near 1 they agree
    whatever the mode is, and the lines hardly tell it.
    """

    gain: FloatArray  # (n_modes, n_frf, 2, 2) (1 - J)^-1, of real and imaginary part of the eigenvalue
    constant: ComplexArray  # (n_modes, n_frf, 2) 1/kg over (rad/s)^2: how the modal constant goes along
    remainder: ComplexArray  # (n_modes, n_frf) (rad/s)^2 that further rounds would move the eigenvalue by

    @property
    def strength(self) -> FloatArray:
        """(n_modes, n_frf): by what factor an error grows or shrinks at most; 1 without feedback."""
        size = np.linalg.svd(self.gain, compute_uv=False)
        return np.asarray(np.maximum(size[..., 0], 1 / size[..., 1]))

    def settled(self, covariance: FloatArray) -> FloatArray:
        """Return the covariance of modes that agree with the lines they corrected.

        Parameters
        ----------
        covariance
            (n_modes, n_frf, 4, 4) of real and imaginary part of eigenvalue and modal constant, of fits to
            lines that are held.
        """
        along = np.stack([self.constant.real, self.constant.imag], axis=2) @ self.gain
        through = np.zeros_like(covariance)
        through[..., :2, :2], through[..., 2:, :2] = self.gain, along
        through[..., 2:, 2:] = np.eye(2)
        return np.asarray(through @ covariance @ through.swapaxes(-1, -2))


def feedback(
    refit: Callable[[ComplexArray], tuple[ComplexArray, ComplexArray]], eigenvalue: ComplexArray
) -> LeakageFeedback:
    """Return how fits follow the modes that their lines are corrected by, from differences.

    Parameters
    ----------
    refit
        From eigenvalues to correct lines by, (n_modes, n_frf) (rad/s)^2, to eigenvalues and modal constants,
        1/kg, fitted to these lines.
    eigenvalue
        (n_modes, n_frf) at which both have settled, (rad/s)^2.
    """
    step = STEP * np.maximum(np.abs(eigenvalue.imag), 1e-6 * np.abs(eigenvalue))
    fitted, constant = refit(eigenvalue)
    moved = [refit(eigenvalue + part * step) for part in (1, 1j)]
    slope = np.stack([(there - fitted) / step for there, _ in moved], axis=2)
    along = np.stack([(there - constant) / step for _, there in moved], axis=2)
    gain = _inverse(np.eye(2) - np.stack([slope.real, slope.imag], axis=2))
    left = fitted - eigenvalue
    rest = np.einsum("mjpq,mjq->mjp", gain, np.stack([left.real, left.imag], axis=2))
    return LeakageFeedback(gain, along, np.asarray(rest[..., 0] + 1j * rest[..., 1]))


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return inverses, (..., 2, 2), in which no direction counts for less than `LEAST`."""
    left, size, right = np.linalg.svd(matrix)
    return np.asarray(
        (right.swapaxes(-1, -2) / np.maximum(size, LEAST)[..., None, :]) @ left.swapaxes(-1, -2)
    )

"""What the modes that a large system was not solved for add to its receptance."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.losses import Losses
from modallab.fe.settings import RECEPTANCE

# Modes above start at twice the highest frequency asked for, so each term is a quarter of the one
# before at most: what is left out is below 1 % of what these modes add.


@dataclass(frozen=True, eq=False)
class ModalTruncation:
    """Modes above a basis, as a series in the square of frequency: none of them is known.

    With sigma = `shift`, 1/(lambda_s - omega^2) = sum_k (omega^2 + sigma)^k / (lambda_s + sigma)^(k+1),
    and powers of (K + sigma M)^-1 M give the sums over all modes; those of the basis are taken out of
    every one, or rounding would bring them back enlarged.

    Their damping is that of mass and stiffness in the mean of all members: where a member is all but
    taken out, as by a hinge, what is left of it is a small difference of large numbers with a loss each.
    """

    mass: csc_array  # (n, n) kg
    solve: Callable[[FloatArray], FloatArray]  # x of (K + sigma M) x = f, column by column
    shift: float  # rad^2/s^2
    shapes: FloatArray  # (n, m) of the basis, undamped, mass-normalised
    losses: Losses | None = None

    def at(self, omega: FloatArray, outputs: FloatArray, inputs: FloatArray) -> ComplexArray:
        """Return left^T (alpha above) right, (n_freq, n_left, n_right), m/N, at `omega` rad/s."""
        by_mass, by_stiffness = (0.0, 0.0) if self.losses is None else self.losses.mean(omega)
        # lambda (1 + i b) + i a - omega^2 = (1 + i b) (lambda - square)
        factor = np.asarray(1 + 1j * by_stiffness)[..., None]
        square = ((omega**2 - 1j * by_mass) / (1 + 1j * by_stiffness))[:, None]
        powers = (square + self.shift) ** np.arange(RECEPTANCE.truncation_terms) / factor
        columns = self.static(inputs)
        terms = [outputs.T @ columns]
        for _ in range(RECEPTANCE.truncation_terms - 1):
            columns = self.static(self.mass @ columns)
            terms.append(outputs.T @ columns)
        return np.asarray(np.tensordot(powers, np.array(terms), 1), complex)

    def static(self, loads: FloatArray) -> FloatArray:
        """Return how the modes above move, (n, k), under slow loads (n, k)."""
        truncated_loads = loads - self._mass_times_shapes @ (self.shapes.T @ loads)
        motion = self.solve(np.ascontiguousarray(truncated_loads))
        return np.asarray(motion - self.shapes @ (self._mass_times_shapes.T @ motion))

    @cached_property
    def _mass_times_shapes(self) -> FloatArray:
        """(n, m) M Phi."""
        return np.asarray(self.mass @ self.shapes)

    def with_scaled_eigenvalues(self, factor: float) -> "ModalTruncation":
        """Return what modes of the same shapes add whose eigenvalues are so many times as large."""

        def solve(loads: FloatArray) -> FloatArray:
            return self.solve(loads) / factor

        return ModalTruncation(self.mass, solve, self.shift * factor, self.shapes)

"""Receptance of the truncated modes of a large system by a power series."""

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
    """Contribution of the modes above a basis as a series in the square of frequency.

    With sigma = `shift`, 1/(lambda_s - omega^2) = sum_k (omega^2 + sigma)^k / (lambda_s + sigma)^(k+1),
    and powers of (K + sigma M)^-1 M give the sums over all modes; modes of the basis are projected out of
    every term, as rounding would amplify them.

    Their damping is proportional, with the mean coefficients of all members: a member that is nearly
    removed, as by a hinge, would be a small difference of large numbers with a loss each.
    """

    mass: csc_array  # (n, n) kg
    solve: Callable[[FloatArray], FloatArray]  # x of (K + sigma M) x = f, column by column
    shift: float  # rad^2/s^2
    shapes: FloatArray  # (n, m) of the basis, undamped, mass-normalised
    losses: Losses | None = None

    def at(self, omega: FloatArray, outputs: FloatArray, inputs: FloatArray) -> ComplexArray:
        """Return the receptance of the truncated modes, (n_freq, n_out, n_in), m/N, at `omega` rad/s."""
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
        """Return the quasi-static displacements (n, k) of the truncated modes under loads (n, k)."""
        truncated_loads = loads - self._mass_times_shapes @ (self.shapes.T @ loads)
        motion = self.solve(np.ascontiguousarray(truncated_loads))
        return np.asarray(motion - self.shapes @ (self._mass_times_shapes.T @ motion))

    @cached_property
    def _mass_times_shapes(self) -> FloatArray:
        """(n, m) M Phi."""
        return np.asarray(self.mass @ self.shapes)

    def with_scaled_eigenvalues(self, factor: float) -> "ModalTruncation":
        """Return the truncated modes with eigenvalues multiplied by a factor."""

        def solve(loads: FloatArray) -> FloatArray:
            return self.solve(loads) / factor

        return ModalTruncation(self.mass, solve, self.shift * factor, self.shapes)

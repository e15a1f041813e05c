"""What the modes that a large system was not solved for add to its receptance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray

# Modes above start at twice the highest frequency asked for, so each term is a quarter of the one
# before at most: what is left out is below 1 % of what these modes add.
TERMS = 4


@dataclass(frozen=True, eq=False)
class Remainder:
    """Modes above a basis, as a series in the square of frequency: none of them is known.

    With sigma = `shift`, 1/(lambda_s - omega^2) = sum_k (omega^2 + sigma)^k / (lambda_s + sigma)^(k+1),
    and powers of (K + sigma M)^-1 M give the sums over all modes; those of the basis are taken out of
    every one, or rounding would bring them back enlarged. Damping is left out, as small here.
    """

    mass: csc_array  # (n, n) kg
    solve: Callable[[FloatArray], FloatArray]  # x of (K + sigma M) x = f, column by column
    shift: float  # rad^2/s^2
    shapes: FloatArray  # (n, m) of the basis, undamped, mass-normalised

    def at(self, omega: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
        """Return left^T (alpha above) right, (n_freq, n_left, n_right), m/N, at `omega` rad/s."""
        powers = ((omega**2 + self.shift)[:, None]) ** np.arange(TERMS)
        columns = self.static(right)
        terms = [left.T @ columns]
        for _ in range(TERMS - 1):
            columns = self.static(self.mass @ columns)
            terms.append(left.T @ columns)
        return np.tensordot(powers, np.array(terms), 1)

    def static(self, loads: FloatArray) -> FloatArray:
        """Return how the modes above move, (n, k), under slow loads (n, k)."""
        above = loads - self.mass @ (self.shapes @ (self.shapes.T @ loads))
        moved = self.solve(np.ascontiguousarray(above))
        return np.asarray(moved - self.shapes @ (self.shapes.T @ (self.mass @ moved)))

    def stretched(self, factor: float) -> "Remainder":
        """Return what modes of the same shapes add whose eigenvalues are so many times as large."""

        def solve(loads: FloatArray) -> FloatArray:
            return self.solve(loads) / factor

        return Remainder(self.mass, solve, self.shift * factor, self.shapes)

"""Bars in a plane: mass and stiffness by Euler and Bernoulli, modes, and receptances with attachments.

Element matrices: Przemieniecki, Theory of Matrix Structural Analysis (1968), chapters 5 and 11. Attachments
by the Woodbury identity.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Complexes = NDArray[np.complexfloating]
Attachment = tuple[Reals, Callable[[Reals], Complexes]]
"""Column (n_dof,) of the motion that a dynamic stiffness (n_freq,), N/m, opposes."""
DOFS = 3  # of a node: along X, along Y, rotation
Y = 1
STRAIGHT = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
BENT = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], float)
ACROSS, ALONG = [1, 2, 4, 5], [0, 3]


@dataclass(frozen=True, eq=False)
class Bars:
    """Bars between nodes, each with its own modulus and density."""

    points: Reals
    """(n_nodes, 2), m."""
    ends: NDArray[np.int64]
    """(n_bars, 2), node indices."""
    modulus: Reals
    """(n_bars,), N/m^2."""
    density: Reals
    """(n_bars,), kg/m^3."""
    area: float
    """m^2."""
    second_moment: float
    """m^4."""
    loss_factor: float
    """1, hysteretic, of all bars."""
    clamped: tuple[int, ...] = ()
    """Indices of fixed nodes."""
    joints: dict[int, float] = field(default_factory=dict)
    """Rotational flexibility, rad/(N m), at the first end of a bar, by the bar's index."""
    mode_factors: Reals | None = None
    """(n_modes,), factors of the modes' loss factors; None: all 1."""

    def dof(self, node: int, direction: int) -> int:
        """Return the index of a DoF."""
        return DOFS * node + direction

    @property
    def n_dof(self) -> int:
        """Number of DoFs: those of nodes, then the rotation of each bar behind its joint."""
        return DOFS * len(self.points) + len(self.joints)

    def column(self, node: int, direction: int) -> Reals:
        """Return the column (n_dof,) of a DoF."""
        column = np.zeros(self.n_dof)
        column[self.dof(node, direction)] = 1.0
        return column

    def matrices(self) -> tuple[Reals, Reals]:
        """Return mass and stiffness, (n_dof, n_dof)."""
        n = self.n_dof
        mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
        behind_joint = {bar: n - len(self.joints) + i for i, bar in enumerate(self.joints)}
        for bar, (first, second) in enumerate(self.ends):
            m, k = self._of_bar(bar)
            rows = np.r_[DOFS * first : DOFS * first + DOFS, DOFS * second : DOFS * second + DOFS]
            if bar in behind_joint:
                pair = [rows[2], behind_joint[bar]]
                stiffness[np.ix_(pair, pair)] += np.array([[1, -1], [-1, 1]]) / self.joints[bar]
                rows[2] = behind_joint[bar]
            mass[np.ix_(rows, rows)] += m
            stiffness[np.ix_(rows, rows)] += k
        return mass, stiffness

    def _of_bar(self, bar: int) -> tuple[Reals, Reals]:
        along = self.points[self.ends[bar, 1]] - self.points[self.ends[bar, 0]]
        length = float(np.hypot(*along))
        scale = np.array([1.0, length, 1.0, length])
        mass, stiffness = np.zeros((6, 6)), np.zeros((6, 6))
        weight = self.density[bar] * self.area * length
        mass[np.ix_(ACROSS, ACROSS)] = weight * STRAIGHT * np.outer(scale, scale)
        mass[np.ix_(ALONG, ALONG)] = weight / 6 * np.array([[2, 1], [1, 2]])
        bending = self.modulus[bar] * self.second_moment / length**3 * BENT * np.outer(scale, scale)
        stiffness[np.ix_(ACROSS, ACROSS)] = bending
        stiffness[np.ix_(ALONG, ALONG)] = (
            self.modulus[bar] * self.area / length * np.array([[1, -1], [-1, 1]])
        )
        c, s = along / length
        turn = np.kron(np.eye(2), np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
        return turn.T @ mass @ turn, turn.T @ stiffness @ turn

    @cached_property
    def modes(self) -> tuple[Reals, Reals]:
        """Squared natural frequencies (n_modes,), rad^2/s^2, and mass-normalised shapes (n_dof, n_modes)."""
        mass, stiffness = self.matrices()
        fixed = [DOFS * node + i for node in self.clamped for i in range(DOFS)]
        free = np.setdiff1d(np.arange(len(mass)), fixed)
        squares, shapes = scipy.linalg.eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
        full = np.zeros((len(mass), len(free)))
        full[free] = shapes
        return np.maximum(squares, 0.0), full

    @cached_property
    def losses(self) -> Reals:
        """(n_modes,), loss factors of the modes."""
        factors = np.ones(len(self.modes[0]))
        if self.mode_factors is not None:  # joints add modes far above all others
            factors[: len(self.mode_factors)] = self.mode_factors
        return np.asarray(self.loss_factor * factors)

    def receptance(self, columns: Sequence[Reals], omega: Reals) -> Complexes:
        """Return receptances (n_freq, n, n) between columns, m/N, without attachments."""
        squares, shapes = self.modes
        at = np.array(columns) @ shapes
        poles = 1 / (squares * (1 + 1j * self.losses) - (omega**2)[:, None])
        return np.asarray(np.einsum("fm,am,bm->fab", poles, at, at, optimize=True))

    def attached(
        self, columns: Sequence[Reals], attachments: Sequence[Attachment], omega: Reals
    ) -> Complexes:
        """Return receptances (n_freq, n, n) between columns, m/N, with attachments."""
        n = len(columns)
        alpha = self.receptance([*columns, *(column for column, _ in attachments)], omega)
        if not attachments:
            return alpha
        z = np.array([stiffness(omega) for _, stiffness in attachments]).T
        inner = np.eye(len(attachments)) + z[:, :, None] * alpha[:, n:, n:]
        forces = np.linalg.solve(inner, z[:, :, None] * alpha[:, n:, :n])
        return np.asarray(alpha[:, :n, :n] - alpha[:, :n, n:] @ forces)


def correlated(points: Reals, length: float, rng: np.random.Generator) -> Reals:
    """Return a random field (n,) of variance 1 over points (n, 2), correlated over a length, m."""
    distances = np.linalg.norm(points[:, None] - points[None], axis=-1)
    covariance = np.exp(-0.5 * (distances / length) ** 2) + 1e-9 * np.eye(len(points))
    return np.asarray(np.linalg.cholesky(covariance) @ rng.standard_normal(len(points)))

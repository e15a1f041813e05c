"""Shear flexibility and rotary inertia of Timoshenko beams."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray

BENDING_ROWS = [1, 2, 4, 5]  # (v, theta) at each end, among (u, v, theta)


def _pattern(a: float, b: float, c: float, d: float, e: float, f: float) -> FloatArray:
    """Return the symmetric (4, 4) matrix of a straight bar from its six independent entries."""
    return np.array([[a, b, c, d], [b, e, -d, f], [c, -d, a, -b], [d, f, -b, e]])


# Coefficients of 1, phi, phi^2, with rotations measured in units of 1 / length.
_BENDING = np.array([_pattern(12, 6, -12, 6, 4, 2), _pattern(0, 0, 0, 0, 1, -1)])
_TRANSLATION = np.array(
    [
        _pattern(156, 22, 54, -13, 4, -3) / 420,
        _pattern(84, 11, 36, -9, 2, -2) / 120,
        _pattern(40, 5, 20, -5, 1, -1) / 120,
    ]
)
_ROTATION = np.array(
    [
        _pattern(36, 3, -36, 3, 4, -1) / 30,
        _pattern(0, -3, 0, -3, 1, -1) / 6,
        _pattern(0, 0, 0, 0, 2, 1) / 6,
    ]
)


def _summed(coefficients: FloatArray, length: FloatArray, phi: FloatArray) -> FloatArray:
    powers = phi[..., None] ** np.arange(len(coefficients))
    scale = np.stack([np.ones_like(length), length, np.ones_like(length), length], axis=-1)
    plain = np.tensordot(powers, coefficients, axes=1)
    return np.asarray(plain * (scale[..., :, None] * scale[..., None, :]))


def bending_stiffness(length: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the bending stiffness of bars of E I = 1, (..., 4, 4), DoFs (v, theta) at each end.

    Parameters
    ----------
    length
        (...) m.
    phi
        (...) shear flexibility 12 E I / (kappa A G L^2); 0 is the beam of Bernoulli and Euler.

    Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6.
    """
    return _summed(_BENDING, length, phi) / (length**3 * (1 + phi))[..., None, None]


def sway_mass(length: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the consistent mass of transverse motion of bars of rho A = 1, (..., 4, 4).

    Source: Friedman and Kosmatka, Computers and Structures 47 (1993) 473-481.
    """
    return _summed(_TRANSLATION, length, phi) * (length / (1 + phi) ** 2)[..., None, None]


def rotary_inertia(length: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the consistent mass of turning cross-sections of bars of rho I = 1, (..., 4, 4).

    Source: Friedman and Kosmatka (1993).
    """
    return _summed(_ROTATION, length, phi) / (length * (1 + phi) ** 2)[..., None, None]


@dataclass(frozen=True, eq=False)
class Shear:
    """Shear and rotary inertia that can be added to members, and the fraction that they have.

    Members of the Timoshenko element include both: their `flexibility` and `gyration` are 0.
    """

    points: FloatArray  # (n_members, 2, 2) m, x and y of each end
    rigidity: FloatArray  # (n_members,) E I, N m^2
    line_mass: FloatArray  # (n_members,) rho A, kg/m
    flexibility: FloatArray  # (n_members,) phi
    gyration: FloatArray  # (n_members,) I / A, m^2
    amount: FloatArray  # (n_members,) share of both that the members have: 0 Bernoulli-Euler, 1 Timoshenko
    consistent_mass: float = 1.0  # share of the shear flexibility in the shapes of the mass matrix

    def of(self, e: int) -> "Shear":
        """Return the same for one member."""
        only = slice(e, e + 1)
        return Shear(
            self.points[only],
            self.rigidity[only],
            self.line_mass[only],
            self.flexibility[only],
            self.gyration[only],
            self.amount[only],
            self.consistent_mass,
        )

    def scaled(self, *, mass: float | FloatArray, stiffness: float | FloatArray) -> "Shear":
        """Return the data of members with mass and stiffness multiplied, all or (n_members,) each."""
        return replace(self, rigidity=self.rigidity * stiffness, line_mass=self.line_mass * mass)

    def more(self, amount: float, consistent_mass: float = 1.0) -> "Shear":
        """Return the data of members with an additional amount of shear and rotary inertia.

        Of two shares in the mass matrix the smaller one holds.
        """
        share = min(self.consistent_mass, consistent_mass)
        return replace(self, amount=self.amount + amount, consistent_mass=share)

    def added(self, amount: float, consistent_mass: float = 1.0) -> tuple[FloatArray, FloatArray]:
        """Return the changes of mass and bending stiffness by an added amount, (n_members, 6, 6) each."""
        mass, bending = self.more(amount, consistent_mass)._parts()
        mass_now, bending_now = self._parts()
        return mass - mass_now, bending - bending_now

    def _parts(self) -> tuple[FloatArray, FloatArray]:
        across = self.points[:, 1] - self.points[:, 0]
        length = np.hypot(*across.T)
        phi = self.amount * self.flexibility
        phi_of_mass, gyration = self.consistent_mass * phi, self.amount * self.gyration
        sway = self.line_mass[:, None, None] * sway_mass(length, phi_of_mass)
        rotary = (self.line_mass * gyration)[:, None, None] * rotary_inertia(length, phi_of_mass)
        bending = self.rigidity[:, None, None] * bending_stiffness(length, phi)
        # (v, theta) of each end from (X, Y, RZ) of each end
        rotation = np.zeros((len(length), 4, 6))
        for end in (0, 1):
            rotation[:, 2 * end, 3 * end : 3 * end + 2] = (
                np.stack([-across[:, 1], across[:, 0]], 1) / length[:, None]
            )
            rotation[:, 2 * end + 1, 3 * end + 2] = 1.0
        transposed = rotation.swapaxes(1, 2)
        return np.asarray(transposed @ (sway + rotary) @ rotation), np.asarray(
            transposed @ bending @ rotation
        )

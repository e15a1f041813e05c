"""Hysteretic and viscous damping of each member in proportion to its mass and stiffness."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping


@dataclass(frozen=True, eq=False)
class Losses:
    """D_e = a M_e + b K_e, hysteretic, and C_e = a' M_e + b' K_e, viscous; (n_members,) each."""

    stiffness: FloatArray  # b, a member's loss factor
    mass: FloatArray  # a, rad^2/s^2
    viscous_stiffness: FloatArray  # b', s
    viscous_mass: FloatArray  # a', 1/s

    @classmethod
    def of(cls, damping: Damping, loss_factor: FloatArray) -> "Losses":
        """Return the damping of members with some loss factors, (n_members,), under a damping law."""
        zeros = np.zeros(len(loss_factor))
        if isinstance(damping, StructuralDamping):
            return cls(loss_factor, zeros + damping.mass_coefficient, zeros, zeros)
        if isinstance(damping, ViscousDamping):
            return cls(
                loss_factor, zeros, zeros + damping.stiffness_coefficient, zeros + damping.mass_coefficient
            )
        return cls(loss_factor, zeros, zeros, zeros)

    def mean(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the means of a + omega a' and b + omega b' over all members, (n_freq,), at `omega` rad/s."""
        by_mass = self.mass.mean() + omega * self.viscous_mass.mean()
        return by_mass, self.stiffness.mean() + omega * self.viscous_stiffness.mean()

    def scaled(self, factor: float) -> "Losses":
        """Return losses with the part in proportion to stiffness multiplied."""
        return Losses(self.stiffness * factor, self.mass, self.viscous_stiffness * factor, self.viscous_mass)

    def to_viscous(self, share: float, omega: float) -> "Losses":
        """Return losses with a fraction of the hysteretic part made viscous, equal at `omega` rad/s."""
        remaining, converted = 1 - share, share / omega
        return Losses(
            remaining * self.stiffness,
            remaining * self.mass,
            self.viscous_stiffness + converted * self.stiffness,
            self.viscous_mass + converted * self.mass,
        )

    def to_hysteretic(self, share: float, omega: float) -> "Losses":
        """Return losses with a fraction of the viscous part made hysteretic, equal at `omega` rad/s."""
        remaining, converted = 1 - share, share * omega
        return Losses(
            self.stiffness + converted * self.viscous_stiffness,
            self.mass + converted * self.viscous_mass,
            remaining * self.viscous_stiffness,
            remaining * self.viscous_mass,
        )

    def matrices(self, mass: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return D_e and C_e of members of that mass and stiffness, (n_members, 6, 6) each."""
        a, b, c, d = (
            part[:, None, None]
            for part in (self.mass, self.stiffness, self.viscous_mass, self.viscous_stiffness)
        )
        return a * mass + b * stiffness, c * mass + d * stiffness

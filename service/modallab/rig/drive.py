"""What stands between a source and the structure: the moving parts of an exciter."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem

RIGID = 0.01  # loss factor of what joins armature and structure: keeps their resonance finite


@dataclass(frozen=True)
class Drive:
    """One exciter: an armature that the source's force P moves, joined to the drive point.

    P = F + Z_a x_a, F = (x_a - x) / C: for a mass alone, rigidly joined, P = F + m a of the 1992 thesis
    [5.2]. The coil's reaction to its own motion is part of Z_a where an amplifier keeps its voltage.
    """

    dof: Dof
    mass: float = 0.0  # kg, moved by the source behind the sensing element
    stiffness: float = 0.0  # N/m, armature to its frame
    viscous: float = 0.0  # N s/m
    compliance: float = 0.0  # m/N, between armature and structure
    force_factor: float = 0.0  # N/A, of a coil whose voltage is kept; 0: its current is kept
    resistance: float = 1.0  # Ohm
    inductance: float = 0.0  # H

    @property
    def plain(self) -> bool:
        """Whether nothing moves behind the sensing element: F = P."""
        return not (self.mass or self.stiffness or self.viscous or self.force_factor)

    def impedance(self, omega: FloatArray) -> ComplexArray:
        """Return Z_a, force per displacement of the armature, (n_freq,) N/m, at `omega` rad/s."""
        viscous = self.viscous + self.force_factor**2 / self._coil(omega)
        return np.asarray(self.stiffness + 1j * omega * viscous - self.mass * omega**2)

    def flexibility(self) -> complex:
        """Return C, m/N, with the little damping it has."""
        return self.compliance / (1 + 1j * RIGID)

    def shaping(self, omega: FloatArray) -> ComplexArray:
        """Return the source's force per what the amplifier is told, (n_freq,): the current lags."""
        if not self.force_factor:
            return np.ones(len(omega), complex)
        return np.asarray(self.resistance / self._coil(omega))

    def _coil(self, omega: FloatArray) -> ComplexArray:
        return np.asarray(self.resistance + 1j * omega * self.inductance)

    def attached_to(self, system: DynamicSystem) -> DynamicSystem:
        """Return the structure with the exciter's moving parts on it, for resonances of both together.

        The coil's inductance is left out.
        """
        if self.plain:
            return system
        column = system.selection((self.dof,))
        viscous = self.viscous + self.force_factor**2 / self.resistance
        own = np.array([self.mass, self.stiffness, viscous])[:, None, None]
        if not self.compliance or not self.mass:
            mass, stiffness, damper = own
            return system.attach(Attachment(column, mass, stiffness, viscous=damper))
        mass, stiffness, damper = own * np.diag([0.0, 1.0])
        joint = np.array([[1.0, -1.0], [-1.0, 1.0]]) / self.compliance
        return system.attach(Attachment(column, mass, stiffness + joint, RIGID * joint, damper, inner=1))


def transmission(drives: tuple[Drive, ...], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    """Return the forces on the structure per force of each source, (n_run, n_freq, n_in, n_in).

    F = (I + Z_a (C + alpha))^-1 G P [5.3], for several exciters that feel each other through the structure.

    Parameters
    ----------
    omega
        (n_freq,) rad/s.
    alpha
        (n_run, n_freq, n_in, n_in) receptance of the drive points, m/N.
    """
    n_in = len(drives)
    unit = np.broadcast_to(np.eye(n_in, dtype=complex), alpha.shape)
    if all(drive.plain for drive in drives):
        return unit
    z = np.array([drive.impedance(omega) for drive in drives]).T[:, :, None]
    compliance = np.diag([drive.flexibility() for drive in drives])
    shaping = np.array([drive.shaping(omega) for drive in drives]).T
    if n_in == 1:  # one division instead of a solver call for every line
        return np.asarray(shaping[:, :, None] / (1 + z * (alpha + compliance)))
    felt = np.linalg.inv(unit + z * (alpha + compliance))
    return np.asarray(felt * shaping[:, None, :])

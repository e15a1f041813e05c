"""Exciter dynamics between source and structure."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.hardware import Coil
from modallab.rig.settings import DRIVE


@dataclass(frozen=True)
class Drive:
    """One exciter: a chain of masses and springs from the drive point to the armature.

    Outwards from the structure: a mass that moves with the drive point, the gauge's spring, the
    stinger, the armature on its suspension, which the source's force P moves. At every mass the force
    passed on grows by Z x, at every spring the motion by C times the force; for an armature alone that
    is P = F + m a of the 1992 thesis [5.2]. A stinger with mass m is the spring C sin(t)/t between two
    masses m/2 tan(t/2)/(t/2), t = omega sqrt(m C): a rod that carries longitudinal waves. Where an
    amplifier keeps the voltage of a coil, what the coil's motion induces is part of the armature's Z.
    """

    dof: Dof
    mass: float = 0.0
    """kg, mass of the armature."""
    stiffness: float = 0.0
    """N/m, armature to its frame."""
    viscous: float = 0.0
    """N s/m, armature to its frame."""
    compliance: float = 0.0
    """m/N, axial compliance of the stinger."""
    stinger_mass: float = 0.0
    """kg, mass of the stinger."""
    gauge_compliance: float = 0.0
    """m/N, compliance of the force gauge."""
    cancelled_mass: float = 0.0
    """kg, mass at the drive point that is cancelled in the measured force."""
    coils: tuple[Coil, ...] = ()
    """Coils driven with controlled voltage; with controlled current there is no back-EMF."""
    stinger_loss_factor: float = DRIVE.joint_loss_factor
    """1, loss factor of the stinger."""

    @property
    def ideal(self) -> bool:
        """Whether nothing moves behind the sensing element: F = P."""
        inert = not (self.mass or self.stinger_mass or self.cancelled_mass)
        return inert and not (self.stiffness or self.viscous or self.coils)

    @property
    def electrical_decay_rates(self) -> tuple[float, ...]:
        """R/L of inductive coils, rad/s; above it a coil acts as a spring rather than a damper."""
        return tuple(coil.resistance / coil.inductance for coil in self.coils if coil.inductance > 0)

    def impedance(self, omega: FloatArray) -> ComplexArray:
        """Return the armature's dynamic stiffness Z, (n_freq,) N/m, at `omega` rad/s."""
        viscous = self.viscous + self._induced(omega)
        return np.asarray(self.stiffness + 1j * omega * viscous - self.mass * omega**2)

    def _induced(self, omega: FloatArray) -> ComplexArray:
        """Return the damping by the coils' back-EMF, (n_freq,) N s/m."""
        no_force = np.zeros(len(omega), complex)
        return sum((coil.force_factor**2 / _electrical(coil, omega) for coil in self.coils), no_force)

    def ladder(self, omega: FloatArray) -> list[tuple[ComplexArray, ComplexArray]]:
        """Return pairs outwards: compliance C (n_freq,) m/N of a spring, stiffness Z (n_freq,) N/m."""
        zeros = np.zeros(len(omega), complex)
        gauge, stinger = self._compliances
        half_turn = omega / 2 * np.sqrt(self.stinger_mass * stinger) / np.pi
        half = -(omega**2) * self.stinger_mass / 2 * np.sinc(half_turn) / np.cos(np.pi * half_turn)
        return [
            (zeros, zeros - self.cancelled_mass * omega**2),
            (zeros + gauge, half),
            (stinger * np.sinc(2 * half_turn), self.impedance(omega) + half),
        ]

    @property
    def _compliances(self) -> tuple[complex, complex]:
        """Complex compliances of gauge and stinger, m/N."""
        gauge = self.gauge_compliance / (1 + 1j * DRIVE.joint_loss_factor)
        return gauge, self.compliance / (1 + 1j * self.stinger_loss_factor)

    def shaping(self, omega: FloatArray) -> ComplexArray:
        """Return the coil force over its static value, (n_freq,): R/(R + i omega L)."""
        out = np.ones(len(omega), complex)
        for coil in self.coils:
            out *= coil.resistance / _electrical(coil, omega)
        return out

    def attached_to(self, system: DynamicSystem, omega: float = 0.0) -> DynamicSystem:
        """Return the structure with the exciter's moving parts attached, the source passive.

        Inductive coils are taken as the spring and the damper that they are at `omega`, rad/s.
        """
        if self.ideal:
            return system
        lumps, joints = self._lumped(omega)
        mass, stiffness, viscous = (np.diag(values) for values in lumps.T)
        k = np.zeros(stiffness.shape, complex)
        for i, (joint, along) in enumerate(joints):
            element = np.array([[1.0, -1.0], [-1.0, 1.0]])
            k[i : i + 2, i : i + 2] += joint * element
            mass[i : i + 2, i : i + 2] -= along / 6 * element  # a third at either end, a sixth across
        return system.attach(
            Attachment(
                system.selection((self.dof,)),
                mass,
                stiffness + k.real,
                k.imag,
                viscous,
                inner=len(joints),
            )
        )

    def _lumped(self, omega: float) -> tuple[FloatArray, list[tuple[complex, float]]]:
        """Return mass, stiffness, damping of the lumps (n, 3), complex stiffness and mass of the joints.

        A lump without mass, or too light to resonate on its joint, is added to its inner neighbour.
        """
        induced = self._induced(np.array([omega]))[0]
        armature_suspension = (self.stiffness - omega * induced.imag, self.viscous + induced.real)
        half = self.stinger_mass / 2
        gauge, stinger = self._compliances
        ladder = [
            (0j, 0.0, (self.cancelled_mass, 0.0, 0.0)),
            (gauge, 0.0, (half, 0.0, 0.0)),
            (stinger, self.stinger_mass, (self.mass + half, *armature_suspension)),
        ]
        lumps, joints, compliance_sum = [np.zeros(3)], [], 0j
        for compliance, along, values in ladder:
            compliance_sum += compliance
            if values[0] * compliance_sum.real * DRIVE.rigid_rate**2 < 1:
                share = 1 / (1 + compliance_sum.real * values[1])  # of the inner end's motion that arrives
                lumps[-1] = lumps[-1] + np.array(values) * [1.0, share, share**2]
            else:
                lumps.append(np.array(values))
                joints.append((1 / compliance_sum, along))
                compliance_sum = 0j
        return np.array(lumps), joints


def _electrical(coil: Coil, omega: FloatArray) -> ComplexArray:
    return np.asarray(coil.resistance + 1j * omega * coil.inductance)


def transmission(drives: tuple[Drive, ...], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    """Return the forces on the structure per force of each source, (n_run, n_freq, n_in, n_in).

    For armatures alone F = (I + Z_a alpha)^-1 P [5.3]. Several exciters are coupled through the structure.

    Parameters
    ----------
    omega
        (n_freq,) rad/s.
    alpha
        (n_run, n_freq, n_in, n_in) receptance of the drive points, m/N.
    """
    n_in = len(drives)
    unit = np.broadcast_to(np.eye(n_in, dtype=complex), alpha.shape)
    if all(drive.ideal for drive in drives):
        return unit
    force = _at_source_end(drives, omega, unit, alpha)
    shaping = np.array([drive.shaping(omega) for drive in drives]).T
    if n_in == 1:  # one division instead of a solver call for every line
        return np.asarray(shaping[:, :, None] / force)
    return np.asarray(np.linalg.inv(force) * shaping[:, None, :])


def reaction(drives: tuple[Drive, ...], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    """Return the passive exciters' dynamic stiffness at the drive points, (n_run, n_freq, n_in, n_in) N/m.

    Per displacement that something else causes, the sources passive: for armatures alone
    (I + Z_a alpha)^-1 Z_a.

    Parameters
    ----------
    omega, alpha
        As for `transmission`.
    """
    unit = np.broadcast_to(np.eye(len(drives), dtype=complex), alpha.shape)
    reaction_force = _at_source_end(drives, omega, np.zeros_like(unit), unit)
    transmitted_force = _at_source_end(drives, omega, unit, alpha)
    return np.asarray(
        reaction_force / transmitted_force
        if len(drives) == 1
        else np.linalg.solve(transmitted_force, reaction_force)
    )


def _at_source_end(
    drives: tuple[Drive, ...], omega: FloatArray, force: ComplexArray, motion: ComplexArray
) -> ComplexArray:
    """Return the force at the source end of the exciters, from force and motion at the structure."""
    for ladder in zip(*(drive.ladder(omega) for drive in drives), strict=True):
        compliances = np.array([compliance for compliance, _ in ladder]).T
        z = np.array([impedance for _, impedance in ladder]).T
        if compliances.any():
            motion = motion + compliances[:, :, None] * force
        if z.any():
            force = force + z[:, :, None] * motion
    return force

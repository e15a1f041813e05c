"""Shakers on a structure, assembled into one matrix with their currents and solved directly."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.structure import Member, PointMass, Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.drive import Drive
from modallab.rig.hardware import Coil
from modallab.rig.settings import DRIVE
from tests.rigs import BAR, STEEL


@dataclass(frozen=True)
class Shaker:
    """All that a shaker can have; its own coordinates are tip, armature and current."""

    dof: Dof
    armature: float = 0.04  # kg
    suspension: float = 8e3  # N/m
    damper: float = 1.5  # N s/m
    stinger: float = 9e5  # N/m
    rod: float = 0.003  # kg, of the stinger
    gauge: float = 4e7  # N/m
    cancelled: float = 0.008  # kg
    force_factor: float = 7.0  # N/A
    resistance: float = 1.5  # Ohm
    inductance: float = 3e-4  # H

    @property
    def drive(self) -> Drive:
        """The same as the rig has it."""
        return Drive(
            self.dof,
            self.armature,
            self.suspension,
            self.damper,
            1 / self.stinger,
            self.rod,
            1 / self.gauge,
            self.cancelled,
            (Coil(self.force_factor, self.resistance, self.inductance),),
        )


def solved(
    system: DynamicSystem, shakers: tuple[Shaker, ...], freq: FloatArray
) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return what follows from each shaker's voltage, as the force F0 = BL E/R that it is told.

    Equations of motion and of the circuits, E = (R + i omega L) I + i omega BL x_a, in one matrix a line.

    Returns
    -------
    forces
        (n_freq, n_in, n_in) N/N, on the structure.
    motions
        (n_freq, n_dof, n_in) m/N, of the structure.
    powers
        (n_freq, n_in) W/N^2 that each shaker's amplifier gives, the others silent.
    """
    n, n_in = len(system.dofs), len(shakers)
    damping = np.zeros((n, n)) if system.damping is None else system.damping.toarray()
    still, heavy = system.stiffness.toarray() + 1j * damping, system.mass.toarray()
    forces, motions, powers = [], [], []
    for omega in 2 * np.pi * freq:
        z = np.zeros((n + 3 * n_in, n + 3 * n_in), complex)
        z[:n, :n] = still - omega**2 * heavy
        right = np.zeros((n + 3 * n_in, n_in), complex)
        for i, shaker in enumerate(shakers):
            point, tip = system.index(shaker.dof), n + 3 * i
            armature, current = tip + 1, tip + 2
            z[point, point] -= omega**2 * shaker.cancelled
            spring = shaker.gauge * (1 + 1j * DRIVE.joint_loss_factor)
            z[np.ix_([point, tip], [point, tip])] += spring * np.array([[1, -1], [-1, 1]])
            spring = shaker.stinger * (1 + 1j * DRIVE.joint_loss_factor)
            t = omega * np.sqrt(shaker.rod / spring)  # dynamic stiffness of a rod: waves along it
            rod = spring * t * np.array([[1 / np.tan(t), -1 / np.sin(t)], [-1 / np.sin(t), 1 / np.tan(t)]])
            z[np.ix_([tip, armature], [tip, armature])] += rod
            z[armature, armature] += (
                shaker.suspension + 1j * omega * shaker.damper - omega**2 * shaker.armature
            )
            z[armature, current] = -shaker.force_factor
            z[current, armature] = 1j * omega * shaker.force_factor
            z[current, current] = shaker.resistance + 1j * omega * shaker.inductance
            right[current, i] = shaker.resistance / shaker.force_factor  # the voltage of 1 N at rest
        x = np.linalg.solve(z, right)
        points, currents = [system.index(shaker.dof) for shaker in shakers], n + 3 * np.arange(n_in) + 2
        springs = np.array([shaker.gauge * (1 + 1j * DRIVE.joint_loss_factor) for shaker in shakers])[:, None]
        inertia = np.array([shaker.cancelled for shaker in shakers])[:, None] * omega**2
        forces.append(springs * (x[currents - 2] - x[points]) + inertia * x[points])
        motions.append(x[:n])
        powers.append(0.5 * (right[currents].diagonal() * x[currents].diagonal().conj()).real)
    return np.array(forces), np.array(motions), np.array(powers)


def block(mass: float, stiffness: float = 0.0) -> DynamicSystem:
    """Return a rigid mass, kg, that moves along X at node 1, on a spring to ground, N/m.

    Half of it sits at either end of a bar of 1 mm, on which the halves resonate above 70 kHz up to 2 kg:
    rigid to 1e-4 below 800 Hz, to 1e-5 below 200 Hz.
    """
    rod_mass = STEEL.density * BAR.area * 0.001
    half = (mass - rod_mass) / 2
    system = assemble(
        Structure(
            nodes={1: (0.0, 0.0), 2: (0.001, 0.0)},
            members=(Member(1, (1, 2), BAR, STEEL),),
            masses=(PointMass(1, half), PointMass(2, half)),
            directions=("X",),
        )
    )
    return system.add_spring(Dof(1, "X"), stiffness) if stiffness else system

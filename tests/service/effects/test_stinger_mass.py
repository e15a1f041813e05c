"""Against a rod in longitudinal vibration, in closed form."""

import numpy as np

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stinger_axial import StingerAxial
from modallab.effects.stinger_mass import StingerMass
from modallab.rig.chain import chain
from modallab.rig.settings import DRIVE
from modallab.rig.setup import RigSetup
from modallab.rig.stinger import StingerRod
from tests.shakers import block

HERE = (Dof(1, "X"),)
# Soft and heavy, so that its mass counts: 41 g, first own axial resonance with free ends at 1.4 kHz.
ROD = StingerRod(diameter=0.01, length=0.37, modulus=1.5e9, density=1400.0)
BLOCK, ARMATURE = 0.5, 0.06


def test_it_is_a_rod_beyond_its_own_resonance() -> None:
    freq = np.linspace(5.0, 2000.0, 400)
    omega = 2 * np.pi * freq
    # u = cos(qx) + B sin(qx) between two masses, u = 1 at the block; what moves the block is E A u'
    modulus, area = ROD.modulus * (1 + 1j * DRIVE.joint_loss_factor), np.pi / 4 * ROD.diameter**2
    q = omega * np.sqrt(ROD.density / modulus)
    b = -BLOCK * omega**2 / (modulus * area * q)
    armature = np.cos(q * ROD.length) + b * np.sin(q * ROD.length)
    pull = modulus * area * q * (b * np.cos(q * ROD.length) - np.sin(q * ROD.length))
    wanted = -BLOCK * omega**2 / (pull - ARMATURE * omega**2 * armature)
    effects = [
        ExciterArmature(mass=ARMATURE),
        StingerAxial(stiffness=ROD.axial_stiffness),
        StingerMass(mass=ROD.mass),
    ]
    found = chain(block(BLOCK), RigSetup(HERE, HERE), effects).respond(freq).force[0, :, 0, 0]
    # the block is rigid to 4e-4 at 2 kHz, which moves what is seen of the steep resonances ten times as much
    np.testing.assert_allclose(found, wanted, rtol=4e-3)
    light = chain(block(BLOCK), RigSetup(HERE, HERE), effects[:2]).respond(freq).force[0, :, 0, 0]
    assert np.abs(light / wanted - 1).max() > 10  # armature and block alone have no second resonance


def test_a_declared_rod_has_it_and_stiffness_alone_has_not() -> None:
    declared = StingerMass.from_setup(RigSetup(HERE, HERE, stinger=ROD))
    assert [effect.mass for effect in declared] == [ROD.mass]

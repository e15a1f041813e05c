"""Against springs in series, and the gauge's own resonance in closed form."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.force_transducer_stiffness import ForceTransducerStiffness
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.chain import chain
from modallab.rig.hardware import Exciter, ForceTransducer
from modallab.rig.settings import DRIVE
from modallab.rig.setup import RigSetup
from tests.shakers import block

HERE = (Dof(1, "X"),)
SETUP = RigSetup(HERE, HERE)
FREQ = np.linspace(5.0, 800.0, 800)
ARMATURE = ExciterArmature(mass=0.1)


def test_an_armature_on_a_soft_gauge_is_two_masses_on_a_spring() -> None:
    mass, stiffness = 0.5, 4e5
    omega = 2 * np.pi * FREQ
    wanted = 1 / (1 + 0.1 / mass - 0.1 * omega**2 / (stiffness * (1 + 1j * DRIVE.joint_loss_factor)))
    found = chain(block(mass), SETUP, [ARMATURE, ForceTransducerStiffness(stiffness=stiffness)])
    # rigid to 1e-4
    np.testing.assert_allclose(found.respond(FREQ).force[0, :, 0, 0], wanted, rtol=1e-3)


def test_gauge_and_stinger_are_springs_in_series() -> None:
    gauge, stinger = 6e5, 3e5
    both = [ARMATURE, ForceTransducerStiffness(stiffness=gauge), StingerAxial(stiffness=stinger)]
    one = [ARMATURE, StingerAxial(stiffness=1 / (1 / gauge + 1 / stinger))]
    found, wanted = (chain(block(0.5), SETUP, effects).respond(FREQ).force for effects in (both, one))
    np.testing.assert_allclose(found, wanted, rtol=1e-12)  # rounding


@pytest.mark.parametrize("stiffness", [None, 0.0])
def test_a_rigid_gauge_is_declared_by_nothing_or_nought(stiffness: float | None) -> None:
    setup = RigSetup(
        HERE, HERE, Exciter(armature_mass=0.1), force_transducer=ForceTransducer(0.01, False, stiffness)
    )
    assert ForceTransducerStiffness.from_setup(setup) == []


def test_a_soft_gauge_is_declared_by_its_stiffness() -> None:
    setup = RigSetup(HERE, HERE, force_transducer=ForceTransducer(stiffness=4e5))
    assert [effect.stiffness for effect in ForceTransducerStiffness.from_setup(setup)] == [4e5]

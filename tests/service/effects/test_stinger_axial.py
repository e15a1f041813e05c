"""Against two masses on a spring in closed form, and the axial mode printed in the 1992 thesis."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.chain import chain
from modallab.rig.settings import DRIVE
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, rig
from tests.shakers import block

HERE = (Dof(1, "X"),)
SETUP = RigSetup(HERE, HERE)
FREQ = np.linspace(5.0, 800.0, 1600)


def test_the_force_is_that_of_two_masses_on_a_spring() -> None:
    mass, armature, stiffness = 0.5, 0.1, 3e5
    omega = 2 * np.pi * FREQ
    spring = stiffness * (1 + 1j * DRIVE.joint_loss_factor)
    wanted = 1 / (1 + armature / mass - armature * omega**2 / spring)
    effects = [ExciterArmature(mass=armature), StingerAxial(at=HERE[0], stiffness=stiffness)]
    found = chain(block(mass), SETUP, effects).respond(FREQ)
    np.testing.assert_allclose(found.force[0, :, 0, 0], wanted, rtol=1e-3)  # rigid to 1e-4
    # F/P is largest where the masses swing against each other
    peak = FREQ[np.abs(found.force[0, :, 0, 0]).argmax()]
    both = np.sqrt(stiffness * (1 / armature + 1 / mass)) / (2 * np.pi)
    assert peak == pytest.approx(both, abs=FREQ[1] - FREQ[0])


def test_on_a_block_that_holds_still_the_armature_resonates_where_the_thesis_has_it() -> None:
    """Appendix D: 5.460e6 N/m and 20 g, 2,630 Hz."""
    effects = [ExciterArmature(mass=0.02), StingerAxial(stiffness=5.460e6)]
    near = np.linspace(2500.0, 2800.0, 3001)
    held = chain(block(2.0, 1e12), SETUP, effects).respond(near).force[0, :, 0, 0]
    # line spacing 0.1 Hz; damping shifts the peak by DRIVE.joint_loss_factor^2/4; printed to the hertz
    assert near[np.abs(held).argmax()] == pytest.approx(2630, abs=0.6)


def test_the_frf_stays_and_the_force_spectrum_changes() -> None:
    effects = [ExciterArmature(mass=0.05), StingerAxial(stiffness=2e5)]
    bare, found = (chain(beam_system(), rig(1, 7), some).respond(FREQ) for some in ([], effects))
    stiff = chain(beam_system(), rig(1, 7), effects[:1]).respond(FREQ)
    np.testing.assert_allclose(found.inertance, bare.inertance, rtol=1e-12)  # rounding
    assert np.abs(found.force / stiff.force - 1).max() > 1.0

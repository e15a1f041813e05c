"""Against two masses on a spring in closed form, and the axial mode printed in the 1992 thesis."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.chain import chain
from modallab.rig.hardware import Exciter
from modallab.rig.settings import DRIVE
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, rig
from tests.shakers import block

HERE = (Dof(1, "X"),)
SETUP = RigSetup(HERE, HERE)
FREQ = np.linspace(5.0, 800.0, 1600)


@pytest.mark.parametrize("loss_factor", [DRIVE.joint_loss_factor, 0.02, 0.3])
def test_the_force_is_that_of_two_masses_on_a_spring(loss_factor: float) -> None:
    mass, armature, stiffness = 0.5, 0.1, 3e5
    omega = 2 * np.pi * FREQ
    spring = stiffness * (1 + 1j * loss_factor)
    wanted = 1 / (1 + armature / mass - armature * omega**2 / spring)
    effects = [ExciterArmature(mass=armature), StingerAxial(HERE[0], stiffness, loss_factor)]
    found = chain(block(mass), SETUP, effects).respond(FREQ)
    np.testing.assert_allclose(found.force[0, :, 0, 0], wanted, rtol=1e-3)  # rigid to 1e-4
    # F/P is largest where the masses swing against each other
    peak = FREQ[np.abs(found.force[0, :, 0, 0]).argmax()]
    both = np.sqrt(stiffness * (1 / armature + 1 / mass)) / (2 * np.pi)
    # a loss factor shifts it by its square over four
    assert peak == pytest.approx(both, abs=FREQ[1] - FREQ[0], rel=loss_factor**2 / 2)


def test_a_lossy_stinger_damps_the_resonance_of_structure_and_armature() -> None:
    """Block and armature swing against each other on a spring of loss factor 0.2: so is the resonance."""
    effects = [ExciterArmature(mass=0.1), StingerAxial(HERE[0], 3e5, 0.2)]
    frequencies, half_widths = chain(block(0.5), SETUP, effects).poles()
    both = np.sqrt(3e5 * (1 / 0.1 + 1 / 0.5)) / (2 * np.pi)
    nearest = np.abs(frequencies[0] - both).argmin()
    # the complex root of 1 + 0.2 i: its parts are those of a small loss factor within its square, 0.04
    assert frequencies[0, nearest] == pytest.approx(both, rel=0.04)
    assert 2 * half_widths[0, nearest] == pytest.approx(0.2 * both, rel=0.04)


def test_trial_stiffnesses_resonate_in_the_band_and_little_above() -> None:
    setup = replace(SETUP, exciter=Exciter(armature_mass=0.02))
    (values,) = StingerAxial().scan_values(beam_system(), setup).values()
    frequencies = np.sqrt(np.array(values) / 0.02) / (2 * np.pi)
    top = setup.analyser.freq[-1]
    assert frequencies[0] < 0.05 * top
    assert frequencies[-1] > 3 * top
    inside = frequencies[frequencies < top]
    assert np.diff(np.log(inside)).max() < 0.02  # a half-power bandwidth of a stinger's loss factor
    without = StingerAxial().scan_values(beam_system(), SETUP)
    assert len(without["stiffness"]) > 3


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

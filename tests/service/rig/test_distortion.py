"""Nonlinear forces in several runs: each under its own motion, or for first looks all under the first's."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.rig.chain import Chain, chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, rig

FORCES = [CubicStiffness(Dof(11, "Y"), 1e10), Friction(Dof(11, "Y"), 0.02, 1e-3)]


def roving(mass: float, excitation: str) -> RigSetup:
    setup = rig(1, 7, 16, excitation=excitation, analyser={"frequency_max": 200.0, "n_lines": 101})
    return replace(setup, accelerometers=Accelerometers(mass, roving=True))


def both(setup: RigSetup, force: Effect) -> tuple[Chain, Chain]:
    return chain(beam_system(), setup, [force], same_in_all_runs=True), chain(beam_system(), setup, [force])


@pytest.mark.parametrize("excitation", ["random", "periodic_random"])
@pytest.mark.parametrize("force", FORCES)
def test_forces_taken_alike_are_exact_where_the_runs_are_alike(excitation: str, force: Effect) -> None:
    quick, full = (expected_spectra(one) for one in both(roving(0.0, excitation), force))
    # runs follow one another from the motion of the one before: a root mean square settles to 1e-10
    np.testing.assert_allclose(quick.xx, full.xx, rtol=1e-8)
    np.testing.assert_allclose(quick.fx, full.fx, rtol=1e-8, atol=1e-8 * np.abs(full.fx).max())


@pytest.mark.parametrize("force", FORCES)
def test_runs_that_differ_by_an_accelerometer_take_nearly_alike_between_the_lines(force: Effect) -> None:
    quick, full = both(roving(0.02, "random"), force)
    assert all(run.local_forces == quick.runs[0].local_forces for run in quick.runs)
    taken = np.array([run.local_forces[0].rms for run in full.runs])
    # 20 g are 0.3 % of the beam's 5.9 kg: they move what it does at one point by a few times as much
    np.testing.assert_allclose(taken, quick.runs[0].local_forces[0].rms, rtol=0.05)
    assert np.ptp(taken) > 0


@pytest.mark.parametrize("force", FORCES)
def test_on_the_lines_no_run_takes_what_another_does(force: Effect) -> None:
    # the accelerometer moves resonances that are narrower than a line past lines that have all the power
    quick, full = both(roving(0.02, "periodic_random"), force)
    taken = np.array([run.local_forces[0].rms for run in full.runs])
    assert [run.local_forces[0].rms for run in quick.runs] == list(taken)
    assert np.ptp(taken) > 0.05 * taken.min()  # more than a first look between the lines forgives


@pytest.mark.parametrize("forces", [FORCES[:1], FORCES[1:], FORCES])
def test_from_a_motion_nearby_the_same_one_is_found(forces: list[Effect]) -> None:
    setup = roving(0.02, "periodic_random")
    nearby = chain(beam_system().add_mass(4, 1e-4), setup, forces).local_rms
    assert nearby is not None
    quick, full = chain(beam_system(), setup, forces, initial_rms=nearby), chain(beam_system(), setup, forces)
    assert full.local_rms is not None
    assert quick.local_rms is not None
    assert np.abs(nearby / full.local_rms - 1).max() > 1e-6
    # two ways to a root mean square that settles to 1e-10
    np.testing.assert_allclose(quick.local_rms, full.local_rms, rtol=1e-8)

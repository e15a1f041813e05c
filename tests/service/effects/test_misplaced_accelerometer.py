"""An accelerometer that sits beside its node."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.effects.misplaced_accelerometer import MisplacedAccelerometer
from modallab.fe.assembly import assemble
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import Support
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, steel_beam

FREQ = np.linspace(2.0, 800.0, 57)


@pytest.mark.parametrize("pitches", [0.5, -0.5, 2.5, -1.0, -3.5])
def test_it_reads_what_a_beam_of_finer_elements_has_there(pitches: float) -> None:
    setup = rig(1, 25, 61)
    effect = MisplacedAccelerometer(at=Channels(dofs(25)), distance=pitches * 1.5 / 80)
    coarse = assemble(steel_beam(n_elements=80))
    found = chain(coarse, setup, [effect]).respond(FREQ).inertance[0, :, 1, 0]
    finer = assemble(steel_beam(n_elements=160))
    there = finer.selection(dofs(round(2 * (24 + pitches)) + 1))
    alpha = direct_receptance(finer, FREQ, there, finer.selection(dofs(1)))[:, 0, 0]
    wanted = -((2 * np.pi * FREQ) ** 2) * alpha
    # Frequencies of n elements are (k l)^4/1440 too high, 8e-6 at 800 Hz: 3e-3 of a peak of loss factor 0.005
    np.testing.assert_allclose(found, wanted, atol=4e-3 * np.abs(wanted).max())
    at_the_node = chain(coarse, setup).respond(FREQ).inertance[0, :, 1, 0]
    assert np.abs(found - wanted).max() < 0.05 * np.abs(at_the_node - wanted).max()


def test_beyond_a_free_end_it_sits_on_a_rigid_arm() -> None:
    system = beam_system()
    setup = rig(1, 21)
    effects = [
        MisplacedAccelerometer(at=Channels(dofs(node)), distance=d) for node, d in ((1, -0.02), (21, 0.02))
    ]
    found = chain(system, setup, effects).respond(FREQ).inertance[0, ..., 0]
    turned = [Dof(1, "RZ"), Dof(21, "RZ")]
    arm = system.selection(dofs(1, 21)) + 0.02 * system.selection(tuple(turned)) * [-1.0, 1.0]
    alpha = direct_receptance(system, FREQ, arm, system.selection(dofs(1)))[..., 0]
    wanted = -((2 * np.pi * FREQ) ** 2)[:, None] * alpha
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_a_sensor_that_looks_the_other_way_goes_on_doing_so() -> None:
    pair = [RigSetup(dofs(1), (Dof(7, "Y", sign),)) for sign in (1, -1)]
    effect = MisplacedAccelerometer(at=Channels(dofs(7)), distance=0.03)
    up, down = (chain(beam_system(), setup, [effect]).respond(FREQ).inertance for setup in pair)
    np.testing.assert_allclose(down, -up, rtol=1e-10, atol=1e-13 * np.abs(up).max())  # order of a sum


@pytest.mark.parametrize("roving", [False, True])
def test_its_mass_is_where_it_is(roving: bool) -> None:
    hardware = Accelerometers(mass=0.05, roving=roving)
    effect = MisplacedAccelerometer(at=Channels(dofs(7)), distance=1.5 / 20)
    found = chain(beam_system(), rig(1, 7, accelerometers=hardware), [effect]).respond(FREQ).inertance
    wanted = chain(beam_system(), rig(1, 8, accelerometers=hardware)).respond(FREQ).inertance
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_it_is_looked_for_at_the_next_node_and_a_little_beside_its_own() -> None:
    effect = MisplacedAccelerometer(at=Channels(dofs(7)))
    distances = np.array(effect.scan_values(beam_system(), rig(1, 7))["distance"])
    for wanted in (-0.075, 0.075):  # m, a member's length
        assert np.isclose(distances, wanted).any()
    assert 0 < np.abs(distances).min() < 0.005
    assert (np.diff(distances) > 0).all()


def test_it_is_not_looked_for_where_nothing_moves() -> None:
    clamped = assemble(replace(steel_beam(), supports=(Support(1, ("Y", "RZ")),)))
    effect = MisplacedAccelerometer(at=Channels(dofs(3)))
    distances = effect.scan_values(clamped, rig(21, 3))["distance"]
    assert -0.15 not in np.round(distances, 9)  # m: node 1 is two members away
    assert 0.15 in np.round(distances, 9)

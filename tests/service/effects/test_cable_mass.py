"""A cable's mass and drag, held against the impedance of a mass and a damper."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.cable_mass import CableMass
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers
from tests.rigs import beam_system, dofs, rig

NODES = (1, 4, 11)
LENGTH = 1.5  # m, of the beam
SYSTEM = beam_system()
FREQ = np.linspace(10.0, 700.0, 60)
ROVING = rig(*NODES, accelerometers=Accelerometers(roving=True))


def test_each_run_carries_the_cable_where_its_accelerometer_sits() -> None:
    mass, drag = 0.008, 300.0
    omega = 2 * np.pi * FREQ
    pick = SYSTEM.selection(dofs(*NODES))
    bare = direct_receptance(SYSTEM, FREQ, pick, pick)
    found = chain(SYSTEM, ROVING, [CableMass(mass=mass, drag=drag)]).respond(FREQ).inertance[:, :, 0, 0]
    own = np.einsum("fjj->jf", bare)
    # x = alpha F - alpha_jj Z x: the cable's force acts back where it is heard
    impedance = 1j * omega * mass * drag - omega**2 * mass
    expected = -(omega**2) * bare[:, :, 0].T / (1 + impedance * own)
    np.testing.assert_allclose(found, expected, rtol=1e-8)  # rounding of a dense solution


def test_without_drag_it_is_a_heavier_accelerometer_and_with_it_is_not() -> None:
    def inertance(effect: CableMass | AccelerometerMass) -> ComplexArray:
        return chain(SYSTEM, ROVING, [effect]).respond(FREQ).inertance

    accelerometer = inertance(AccelerometerMass(mass=0.008))
    np.testing.assert_allclose(inertance(CableMass(mass=0.008, drag=0.0)), accelerometer, rtol=1e-9)
    dragged = inertance(CableMass(mass=0.008, drag=300.0))
    assert np.abs(dragged / accelerometer - 1).max() > 0.1  # 2.4 N s/m takes more than the beam's own loss


def test_the_loss_factor_rises_by_the_drag_over_omega_of_the_share_of_mass_that_moves() -> None:
    mass, drag = 1e-4, 100.0  # light: shapes stay as they are
    loaded = CableMass(at=Dof(1, "Y"), mass=mass, drag=drag).on_system(SYSTEM, ROVING.acquisition_runs[0])
    bare, modes = SYSTEM.modes().elastic(6), loaded.modes().elastic(6)
    share = mass * bare.shapes[SYSTEM.index(Dof(1, "Y"))] ** 2  # of a modal mass of 1 kg
    gained = drag * share / (2 * np.pi * bare.frequencies)
    # A mass also takes from what a kilogram loses: eta = lost/lambda, lambda falls by the same share.
    expected = bare.loss_factors + gained
    np.testing.assert_allclose(modes.loss_factors, expected, rtol=5 * share.max())


def test_a_cable_of_the_log_book_hangs_on_the_accelerometers() -> None:
    declared = rig(1, 7, accelerometers=Accelerometers(cable_mass=0.003))
    assert list(CableMass.from_setup(declared)) == [CableMass(mass=0.003)]
    assert CableMass().drag * 0.003 == pytest.approx(0.06)  # N s/m, within what cables have


def test_a_cable_that_hangs_from_the_corner_grows_with_the_distance_from_it() -> None:
    # a beam of 20 elements: its nodes lie along X from its left end
    positions = {node: (node - 1) / 20 * LENGTH for node in NODES}
    growth = 2.5
    for run, node in zip(ROVING.acquisition_runs, NODES, strict=True):
        (attachment,) = CableMass(mass=0.008, growth=growth).on_system(SYSTEM, run).attachments
        assert attachment.mass is not None
        expected = 0.008 * (1 + growth * positions[node])
        np.testing.assert_allclose(np.diag(attachment.mass), expected, rtol=1e-12)  # rounding


def test_its_reduced_model_is_a_heavier_accelerometer() -> None:
    assert CableMass(mass=0.008, growth=1.0).reduced_model() == (
        AccelerometerMass(mass=0.008),
        ("drag", "growth"),
    )

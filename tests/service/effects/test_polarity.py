"""A channel whose sign is turned."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.effects.polarity import Polarity
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig

FREQ = np.linspace(2.0, 800.0, 57)
SETUP = rig(1, 7, 16)


def test_it_is_a_sensor_that_looks_the_other_way() -> None:
    turned = chain(beam_system(), RigSetup(dofs(1), (Dof(1, "Y"), Dof(7, "Y", -1), Dof(16, "Y"))))
    found = chain(beam_system(), SETUP, [Polarity(at=Channels(dofs(7)))])
    np.testing.assert_array_equal(found.respond(FREQ).inertance, turned.respond(FREQ).inertance)


def test_twice_is_not_at_all() -> None:
    twice = [Polarity(at=Channels(dofs(7))), Polarity(at=Channels(dofs(7)))]
    found, bare = (chain(beam_system(), SETUP, e).respond(FREQ).inertance for e in (twice, []))
    np.testing.assert_array_equal(found, bare)


def test_a_drive_point_seems_to_give_power_and_that_betrays_it() -> None:
    found = chain(beam_system(), SETUP, [Polarity(at=Channels(dofs(1)))]).respond(FREQ).inertance
    bare = chain(beam_system(), SETUP).respond(FREQ).inertance
    assert (bare[0, :, 0, 0].imag > 0).all()  # power flows into a passive structure
    assert (found[0, :, 0, 0].imag < 0).all()


@pytest.mark.parametrize("at", [None, SETUP.drive])
def test_all_responses_turned_are_the_force_turned(at: Dof | None) -> None:
    bare, found = (expected_spectra(chain(beam_system(), SETUP, e)) for e in ([], [Polarity(at=at)]))
    np.testing.assert_array_equal(found.fx, -bare.fx)
    np.testing.assert_array_equal(found.xx, bare.xx)
    np.testing.assert_array_equal(found.ff, bare.ff)


def test_of_several_forces_one_may_be_turned() -> None:
    setup = replace(SETUP, drives=dofs(1, 16))
    assert Dof(16, "Y") in Polarity.places(beam_system(), setup)
    bare, found = (chain(beam_system(), setup, e).respond(FREQ) for e in ([], [Polarity(at=Dof(16, "Y"))]))
    # solving for two forces: rounding times the condition of the force matrix, which is 1 here
    np.testing.assert_allclose(found.inertance, bare.inertance * [1.0, -1.0], rtol=1e-12)

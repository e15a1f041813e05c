"""Two channels that stand for each other."""

from dataclasses import replace

import numpy as np
import pytest

import modallab.effects.swapped_channels as module
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels
from modallab.diagnosis.optimisation.tolerance_effects import AccelerometerTolerance
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.cable_mass import CableMass
from modallab.effects.settings import MIX_UP
from modallab.effects.swapped_channels import SwappedChannels
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, steel_beam

FREQ = np.linspace(2.0, 800.0, 57)
SETUP = rig(1, 7, 16)
SWAPPED = SwappedChannels(at=Channels(dofs(7, 16)))


@pytest.mark.parametrize("roving", [False, True])
def test_each_frf_stands_under_the_name_of_the_other(roving: bool) -> None:
    system = beam_system()
    setup = rig(1, 7, 16, accelerometers=Accelerometers(roving=roving))
    alpha = direct_receptance(system, FREQ, system.selection(dofs(1, 16, 7)), system.selection(dofs(1)))
    wanted = -((2 * np.pi * FREQ) ** 2)[:, None] * alpha[..., 0]
    found = chain(system, setup, [SWAPPED]).respond(FREQ).inertance[..., 0]
    by_name = found[:, :, 0].T if roving else found[0]
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(by_name, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_an_accelerometer_keeps_the_sense_in_which_it_sits() -> None:
    upside_down = Dof(16, "Y", -1)
    setup = RigSetup(dofs(1), (Dof(7, "Y"), upside_down))
    swapped = SwappedChannels(at=Channels((Dof(7, "Y"), upside_down)))
    bare, found = (chain(beam_system(), setup, e).respond(FREQ).inertance[0, ..., 0] for e in ([], [swapped]))
    # a difference in which all but one motion cancels: rounding of the larger of the two
    np.testing.assert_allclose(found, bare[:, ::-1], rtol=1e-9, atol=1e-12 * np.abs(bare).max())


@pytest.mark.parametrize(
    "at", [dofs(7), dofs(1, 7, 16), dofs(7, 7), (Dof(7, "Y"), Dof(16, "Y", -1))], ids=str
)
def test_two_channels_as_the_log_book_has_them_are_swapped_and_no_others(at: tuple[Dof, ...]) -> None:
    SWAPPED.check(steel_beam(), SETUP)
    with pytest.raises(InvalidInputError, match="swapped_channels"):
        SwappedChannels(at=Channels(at)).check(steel_beam(), SETUP)


@pytest.mark.parametrize("at", [None, Channels(dofs(7)), Channels(dofs(1, 7, 16))], ids=str)
def test_a_log_book_that_names_other_than_two_is_refused_when_it_is_used(at: Channels | None) -> None:
    with pytest.raises(InvalidInputError, match="swapped_channels"):
        chain(beam_system(), SETUP, [SwappedChannels(at=at)])


@pytest.mark.parametrize(
    "load", [AccelerometerMass(None, 0.01), CableMass(None, 0.01, 50.0), AccelerometerTolerance(None, 0.01)]
)
def test_a_roving_accelerometer_takes_all_its_mass_along(load: Effect) -> None:
    setup = rig(1, 7, 16, accelerometers=Accelerometers(mass=0.05, roving=True))
    bare, found = (
        chain(beam_system(), setup, [load, *effects]).respond(FREQ).inertance for effects in ([], [SWAPPED])
    )
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, bare[[0, 2, 1]], rtol=1e-7, atol=1e-9 * np.abs(bare).max())


def test_every_pair_is_suspected() -> None:
    places = SwappedChannels.places(beam_system(), rig(1, 3, 5))
    assert places == (Channels(dofs(1, 3)), Channels(dofs(1, 5)), Channels(dofs(3, 5)))


def test_of_very_many_channels_neighbours_in_the_log_book_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MIX_UP", replace(MIX_UP, paired_channels=2))
    places = SwappedChannels.places(beam_system(), rig(1, 3, 5))
    assert places == (Channels(dofs(1, 3)), Channels(dofs(3, 5)))

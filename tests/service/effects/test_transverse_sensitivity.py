"""An accelerometer hears motion across its axis."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels
from modallab.effects.transverse_sensitivity import TransverseSensitivity
from modallab.fe.assembly import assemble
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import PLANE
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, steel_beam, tilted_beam

FREQ = np.linspace(2.0, 800.0, 57)
SETUP = rig(1, 7, 16)


@pytest.mark.parametrize("angle", [0.0, 0.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_it_is_the_motion_along_a_slanted_line_solved_line_by_line(angle: float, sign: int) -> None:
    system = assemble(tilted_beam())
    setup = RigSetup(dofs(1), (Dof(7, "Y", sign),))
    effect = TransverseSensitivity(sensitivity=0.04, angle=angle)
    slanted = system.selection((Dof(7, "Y", sign),)) + 0.04 * np.cos(angle) * system.selection((Dof(7, "X"),))
    wanted = direct_receptance(system, FREQ, slanted, system.selection(dofs(1)))[:, 0, 0]
    wanted = -((2 * np.pi * FREQ) ** 2) * wanted
    found = chain(system, setup, [effect]).respond(FREQ).inertance[0, :, 0, 0]
    # rounding of two solutions: 1e-16 times the ratio of the eigenvalues, 1e8 with the axial modes
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-8 * np.abs(wanted).max())


def test_a_sensor_put_on_askew_is_one_of_lower_gain_that_hears_across() -> None:
    """Turned by e it reads cos e Y + sin e X = cos e (Y + tan e X): on a beam tilted by atan(3/4), one that
    looks along the normal (-0.6, 0.8) is 0.8 of one along Y with a sensitivity of -0.75, and bending at a
    resonance moves along the normal alone, 1/0.8 of what is seen along Y."""
    system = assemble(tilted_beam())
    first_bending = chain(system, SETUP).poles()[0][0, 0]
    pair: tuple[list[Effect], ...] = [], [TransverseSensitivity(sensitivity=-0.75)]
    along, slanted = (
        chain(system, SETUP, e).respond(np.array([first_bending])).inertance[0, 0, 2, 0] for e in pair
    )
    # other modes, rigid ones among them, are some per cent of a resonance of loss factor 0.01
    assert np.isclose(0.8 * slanted, along / 0.8, rtol=0.05)


def test_without_motion_across_nothing_is_heard() -> None:
    flat = assemble(replace(steel_beam(), directions=PLANE))
    pair: tuple[list[Effect], ...] = [], [TransverseSensitivity(sensitivity=0.5)]
    bare, found = (chain(flat, SETUP, e).respond(FREQ).inertance for e in pair)
    # bending and axial motion of a straight beam know nothing of each other: rounding
    np.testing.assert_allclose(found, bare, atol=1e-12 * np.abs(bare).max())


def test_a_beam_that_has_only_one_translation_gives_it_no_place() -> None:
    assert TransverseSensitivity.places(beam_system(), SETUP) == ()
    for at in (None, Channels(dofs(7))):
        with pytest.raises(InvalidInputError, match="transverse_sensitivity"):
            TransverseSensitivity(at=at).check(steel_beam(), SETUP)
        TransverseSensitivity(at=at).check(tilted_beam(), SETUP)


def test_the_data_sheet_implies_it() -> None:
    used = Accelerometers(transverse_sensitivity=0.03, transverse_angle=0.2)
    (found,) = TransverseSensitivity.from_setup(rig(7, accelerometers=used))
    assert (found.sensitivity, found.angle, found.at) == (0.03, 0.2, None)


def test_an_angle_is_fitted_where_an_accelerometer_moves_in_all_directions() -> None:
    in_plane = assemble(tilted_beam())
    effect = TransverseSensitivity()
    assert effect.scan_values(in_plane, SETUP) == {}
    assert [name for name, *_ in effect.fitted_specs()] == ["sensitivity"]
    in_space = SimpleNamespace(dofs=[Dof(7, direction) for direction in ("X", "Y", "Z")])
    (angles,) = effect.scan_values(cast("DynamicSystem", in_space), SETUP).values()
    # half a turn in equal steps: a sensitivity at angle + pi is the negative one at the angle
    np.testing.assert_allclose(np.diff(sorted(angles)), np.pi / 3)
    names = [[n for n, *_ in replace(effect, angle=angle).fitted_specs()] for angle in angles]
    assert names == [["sensitivity"], ["sensitivity", "angle"], ["sensitivity", "angle"]]

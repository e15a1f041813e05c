"""Elastic bands: rigid bodies on springs."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Dofs
from modallab.effects.suspension import SuspensionStiffness
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import receptance
from modallab.fe.structure import Support
from modallab.rig.chain import chain
from modallab.rig.suspension import Suspension as Declared
from tests.rigs import beam_system, dofs, rig, steel_beam

MASS = 7800.0 * 5e-4 * 1.5  # kg
ENDS = dofs(1, 21)


def test_a_beam_on_two_bands_bounces_and_rocks_with_the_loss_of_the_bands() -> None:
    setup = rig(1, suspension=Declared(ENDS, stiffness=10.0, loss_factor=0.08))
    system = chain(beam_system(StructuralDamping()), setup).runs[0].system
    basis = system.modes()
    # 2 k / M along, and 2 k (L/2)^2 / (M L^2 / 12) = 6 k / M about the middle
    exact = np.sqrt(np.array([2.0, 6.0]) * 10.0 / MASS) / (2 * np.pi)
    # the beam's own bending gives way by 1e-3 of the bands' stretch
    np.testing.assert_allclose(basis.frequencies[:2], exact, rtol=1e-3)
    np.testing.assert_allclose(basis.loss_factors[:2], 0.08, rtol=1e-3)
    assert basis.n_rigid_body == 0


def test_below_its_bounce_a_suspended_beam_gives_as_its_bands_do() -> None:
    setup = rig(11, suspension=Declared(ENDS, stiffness=10.0, loss_factor=0.05))
    system = chain(beam_system(StructuralDamping(0.005)), setup).runs[0].system
    middle = system.selection((Dof(11, "Y"),))
    found = receptance(system, np.array([0.01]), middle, middle)[0, 0, 0]
    # two bands side by side; inertia adds (0.01 / 0.29)^2, 1e-3, and the beam's bending as much
    assert found == pytest.approx(1 / (20.0 * (1 + 0.05j)), rel=3e-3)


def test_the_log_book_has_one_for_each_band() -> None:
    bands = list(SuspensionStiffness.from_setup(rig(1, suspension=Declared(ENDS, 100.0, 0.05))))
    assert bands == [SuspensionStiffness(at=dof, stiffness=100.0, loss_factor=0.05) for dof in ENDS]
    assert list(SuspensionStiffness.from_setup(rig(1))) == []


@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("suspension.stiffness", lambda: Declared(ENDS, -1.0)),
        ("suspension.loss_factor", lambda: Declared(ENDS, 1.0, float("nan"))),
        ("suspension.at", lambda: Declared((Dof(1, "RZ"),), 1.0)),
        ("suspension.at", lambda: Declared((Dof(1, "Y"), Dof(1, "Y", -1)), 1.0)),
        ("at", lambda: SuspensionStiffness(at=Dof(5, "RZ")).check(steel_beam())),
        ("at", lambda: SuspensionStiffness(at=Dofs(())).check(steel_beam())),
        ("at", lambda: SuspensionStiffness(at=Dofs((Dof(5, "Y"), Dof(5, "RZ")))).check(steel_beam())),
        ("at", lambda: SuspensionStiffness(at=Dofs((Dof(5, "Y"), Dof(5, "Y", -1)))).check(steel_beam())),
    ],
)
def test_a_band_that_cannot_be_is_refused_by_name(field: str, make: Callable[[], object]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.context["field"] == field


def test_a_structure_that_is_held_has_no_bands_to_suspect() -> None:
    held = assemble(replace(steel_beam(), supports=(Support(1, ("Y", "RZ")),)))
    assert SuspensionStiffness.places(held, rig(1)) == ()
    places = SuspensionStiffness.places(beam_system(), rig(1))
    assert [place for place in places if isinstance(place, Dof)] == list(dofs(*range(1, 22)))


def test_two_bands_are_those_at_both() -> None:
    pair = SuspensionStiffness(at=Dofs(ENDS), stiffness=10.0, loss_factor=0.08)
    singles = [SuspensionStiffness(at=dof, stiffness=10.0, loss_factor=0.08) for dof in ENDS]
    middle = beam_system().selection((Dof(11, "Y"),))
    systems = [chain(beam_system(), rig(1), effects).runs[0].system for effects in ([pair], singles)]
    together, apart = (receptance(system, np.array([0.3, 30.0]), middle, middle) for system in systems)
    np.testing.assert_allclose(together, apart, rtol=1e-9)  # the same equations in another order
    assert pair.reduced_model() is None
    assert singles[0].reduced_model() is not None


def test_pairs_of_bands_stand_about_the_centre_of_mass() -> None:
    pairs = [p for p in SuspensionStiffness.places(beam_system(), rig(1)) if isinstance(p, Dofs)]
    assert pairs == [Dofs(dofs(i, 22 - i)) for i in range(1, 11)]


def test_a_heavy_end_moves_the_pairs_of_bands() -> None:
    beam = steel_beam()
    heavy = beam.of_members(
        replace(member, mass_factor=4.0 if member.number > 10 else 1.0) for member in beam.all_members
    )
    # 80 % of the mass in the right half: the centre of mass is 0.3 of half a length, 3 elements, to its right
    pairs = [p for p in SuspensionStiffness.places(assemble(heavy), rig(1)) if isinstance(p, Dofs)]
    assert pairs == [Dofs(dofs(14 - i, 14 + i)) for i in range(7, 0, -1)]

"""A system and what hangs on it: attachments leave the matrices as they were."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.system import DynamicSystem

BEAM = assemble(STRUCTURES["chapter-5-beam"]())


def test_a_mass_lowers_frequencies_and_most_those_that_move_there() -> None:
    at = Dof(1, "Y")
    bare, loaded = BEAM.modes().elastic(8), BEAM.add_mass(1, 0.001).modes().elastic(8)
    shift = loaded.frequencies / bare.frequencies - 1
    # to first order -m phi^2 / 2; the second is of the size of its square
    first = -0.001 * bare.shapes[BEAM.index(at)] ** 2 / 2
    np.testing.assert_allclose(shift, first, rtol=1e-2)


def test_a_mass_moves_with_every_translation_of_its_node() -> None:
    bay = assemble(STRUCTURES["bay"]())
    folded = bay.add_mass(5, 3.0).folded()
    added = (folded.mass - bay.mass).toarray()
    moved = {(dof.node, dof.direction) for dof, entry in zip(bay.dofs, np.diag(added), strict=True) if entry}
    assert moved == {(5, "X"), (5, "Y")}


def test_hanging_something_on_changes_nothing_underneath() -> None:
    before = BEAM.mass.toarray()
    BEAM.add_mass(3, 1.0).add_spring(Dof(3, "Y"), 1e4).change_member(4, mass=1.0).folded()
    np.testing.assert_array_equal(BEAM.mass.toarray(), before)
    assert BEAM.attachments == ()


def test_modes_are_solved_for_once_for_every_variant() -> None:
    assert BEAM.add_mass(3, 1.0).base_modes(800.0) is BEAM.base_modes(800.0)


def test_what_is_hung_on_twice_is_made_once() -> None:
    # every run of a test with a roving accelerometer asks for the same
    def hung(mass: float) -> DynamicSystem:
        return BEAM.add_spring(Dof(3, "Y"), 1e4).add_oscillator(Dof(5, "Y"), mass, 90.0, 0.1).change_member(4)

    one, same, other = hung(0.1), hung(0.1), hung(0.2)
    assert all(a is b for a, b in zip(one.attachments, same.attachments, strict=True))
    assert [a.key == b.key for a, b in zip(one.attachments, other.attachments, strict=True)] == [1, 0, 1]


@pytest.mark.parametrize("name", ["chapter-5-beam", "bay", "cantilever"])
@pytest.mark.parametrize(("mass", "stiffness"), [(1.2, 1.0), (1.0, 0.9), (1.2, 0.9)])
def test_a_scaled_system_is_the_structure_of_another_material(
    name: str, mass: float, stiffness: float
) -> None:
    structure = STRUCTURES[name]()
    every = tuple(member.number for member in structure.members)
    made = change(
        structure,
        [
            MemberChange(every, MemberProperty.DENSITY, factor=mass),
            MemberChange(every, MemberProperty.MODULUS, factor=stiffness),
        ],
    )
    scaled, expected = assemble(structure).scaled(mass=mass, stiffness=stiffness), assemble(made)
    for part in ("mass", "stiffness", "damping"):
        ours, theirs = getattr(scaled, part), getattr(expected, part)
        assert (ours is None) == (theirs is None)
        if theirs is not None:
            np.testing.assert_allclose(ours.toarray(), theirs.toarray(), atol=1e-12 * abs(theirs).max())


def test_a_system_scaled_alike_is_solved_for_once() -> None:
    one, other = BEAM.scaled(mass=1.1), BEAM.add_mass(3, 0.1).scaled(mass=1.1)
    assert one.base_modes(800.0) is other.base_modes(800.0)
    assert len(other.attachments) == 1


@pytest.mark.parametrize("law", [StructuralDamping(0.005, 100.0), ViscousDamping(1e-6, 3.0)])
def test_resonances_are_the_elastic_modes_and_their_half_widths(law: Damping) -> None:
    system = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=law)).add_mass(3, 0.05)
    frequencies, half = system.resonances(800.0)
    basis = system.modes().elastic(8)
    np.testing.assert_allclose(frequencies[:8], basis.frequencies, rtol=1e-4)  # second order in damping
    # half of the half-power bandwidth eta f
    np.testing.assert_allclose(half[:8], basis.loss_factors * basis.frequencies / 2, rtol=1e-2)


@pytest.mark.parametrize("dof", [Dof(99, "Y"), Dof(3, "X")])
def test_a_dof_that_is_not_there_is_refused(dof: Dof) -> None:
    with pytest.raises(UnknownDofError):
        BEAM.selection((dof,))
    with pytest.raises(UnknownDofError):
        BEAM.add_spring(dof, 1.0)


def test_a_mass_needs_a_node_and_a_change_a_member() -> None:
    with pytest.raises(UnknownDofError):
        BEAM.add_mass(99, 1.0)
    with pytest.raises(InvalidInputError):
        BEAM.change_member(99, mass=1.0)


def test_each_mode_may_lose_more_or_less_than_the_law_has_it() -> None:
    more = (0.004, -0.002, 0.0, 0.001)
    bare, lossy = BEAM.modes().elastic(6), BEAM.with_modal_loss(more).modes().elastic(6)
    # A law of mass and stiffness and damping mode by mode leave shapes real: sums to rounding.
    np.testing.assert_allclose(lossy.loss_factors - bare.loss_factors, [*more, 0, 0], atol=1e-9)
    np.testing.assert_allclose(lossy.frequencies, bare.frequencies, rtol=1e-9)
    np.testing.assert_array_equal(BEAM.modes().elastic(6).loss_factors, bare.loss_factors)


def test_what_modes_lose_besides_follows_the_law_that_damping_is_converted_to() -> None:
    more, omega = (0.004, -0.002, 0.003), 500.0
    bare, lossy = BEAM.converted(1.0, omega), BEAM.with_modal_loss(more).converted(1.0, omega)
    before, after = (system.modes().elastic(3) for system in (bare, lossy))
    # viscous damping of the same energy at omega: a loss factor in proportion to frequency
    expected = np.array(more) * 2 * np.pi * before.frequencies / omega
    np.testing.assert_allclose(
        after.loss_factors - before.loss_factors, expected, rtol=1e-3
    )  # squares of both
    doubled = BEAM.with_modal_loss(more).scaled(loss=2.0).modes().elastic(3).loss_factors
    plain = BEAM.scaled(loss=2.0).modes().elastic(3).loss_factors
    np.testing.assert_allclose(doubled - plain, 2 * np.array(more), atol=1e-9)  # sums to rounding


def test_what_modes_lose_besides_is_there_in_matrices_and_receptance() -> None:
    lossy = BEAM.with_modal_loss((0.02, 0.01)).with_modal_loss((0.01,)).add_mass(1, 0.3)
    selected = lossy.selection((Dof(1, "Y"), Dof(9, "Y")))
    freq = np.linspace(20.0, 80.0, 31)
    fast = receptance(lossy, freq, selected, selected)
    # modes up to 2 kHz are written out in the matrices; all others have no such loss: sums to rounding
    np.testing.assert_allclose(fast, direct_receptance(lossy, freq, selected, selected), rtol=1e-6)
    again = receptance(BEAM.with_modal_loss((0.03, 0.01)).add_mass(1, 0.3), freq, selected, selected)
    np.testing.assert_allclose(fast, again, rtol=1e-9)


@pytest.mark.parametrize(
    "alter",
    [
        lambda system: system.change_member(4, bending=-0.5, mass=0.3),
        lambda system: system.change_member(4, bending=1.0).change_member(9, bending=-0.3),
    ],
)
def test_modes_with_altered_members_may_lose_more_or_less_than_the_law_has_it(
    alter: Callable[[DynamicSystem], DynamicSystem],
) -> None:
    more = (0.004, -0.002, 0.0, 0.001)
    bare, lossy = alter(BEAM), alter(BEAM.with_modal_loss(more)).with_loss_of_altered_modes()
    before, after = (system.modes().elastic(6).loss_factors for system in (bare, lossy))
    # exact where shapes stay real; members that lose in proportion to stiffness alone leave them so
    np.testing.assert_allclose(after - before, [*more, 0, 0], atol=1e-6)
    stale = alter(BEAM.with_modal_loss(more)).modes().elastic(6).loss_factors
    assert np.abs(stale - before - [*more, 0, 0]).max() > 5e-5  # of modes of the beam as it was


def test_a_joint_and_an_elastic_support_leave_each_mode_the_loss_stated_for_it() -> None:
    frame = assemble(STRUCTURES["cantilever"]())
    more = (0.004, -0.002, 0.001)
    alterations: list[Callable[[DynamicSystem], DynamicSystem]] = [
        lambda system: system.add_joint(3, 1e-4),
        lambda system: system.soften_support(frame.loaded_supports[0], 1e-6),
    ]
    for alter in alterations:
        bare, lossy = alter(frame), alter(frame.with_modal_loss(more)).with_loss_of_altered_modes()
        before, after = (system.modes().elastic(3).loss_factors for system in (bare, lossy))
        # the rotation inside a joint has next to no inertia of its own, but not none
        np.testing.assert_allclose(after - before, more, atol=1e-5)


def test_masses_and_springs_leave_what_modes_lose_to_the_modes_without_them() -> None:
    lossy = BEAM.with_modal_loss((0.02,)).add_mass(1, 0.3)
    assert lossy.with_loss_of_altered_modes() is lossy
    altered = BEAM.change_member(4, bending=-0.5)
    assert altered.with_loss_of_altered_modes() is altered


def test_resonances_are_as_wide_as_what_their_modes_lose() -> None:
    plain, lossy = BEAM.add_mass(1, 0.01), BEAM.with_modal_loss((0.02,)).add_mass(1, 0.01)
    frequencies, width = lossy.resonances(200.0)
    before, narrow = plain.resonances(200.0)
    np.testing.assert_allclose(frequencies, before, rtol=1e-9)
    # f eta / 2 more, but for the shape of a mode that 10 g of 5.9 kg change by less than a per cent
    assert width[0] - narrow[0] == pytest.approx(frequencies[0] * 0.01, rel=0.02)
    np.testing.assert_allclose(width[1:5], narrow[1:5], rtol=0.02)

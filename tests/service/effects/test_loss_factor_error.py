"""Wrong loss factors, held against strain energy, other models and one member solved for anew."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.place import Members
from modallab.effects.loss_factor_error import LossFactorError
from modallab.fe.assembly import assemble
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests.rigs import dofs, rig, steel_beam

ETA, MASS_PART = 0.005, 100.0
SHOT = AcquisitionRun(dofs(1), dofs(1))
FREQ = np.linspace(10.0, 700.0, 40)


def applied(structure: Structure, effect: LossFactorError) -> DynamicSystem:
    return effect.on_system(assemble(structure), SHOT)


def test_a_mode_gains_the_loss_of_the_member_times_its_share_of_the_strain_energy() -> None:
    """Ungar and Kerwin (1962): eta_r = sum_e eta_e U_e / U."""
    structure, factor = steel_beam(StructuralDamping(1e-4)), 3.0
    system = assemble(structure)
    basis, table = system.modes().elastic(6), system.members
    assert table is not None
    e = table.position(4)
    held = basis.shapes.real[table.rows[e][table.rows[e] >= 0]]  # a beam's nodes have no X
    stiffness = table.bending[e][np.ix_(table.rows[e] >= 0, table.rows[e] >= 0)]
    share = np.einsum("ir,ij,jr->r", held, stiffness, held) / basis.eigenvalues.real
    found = applied(structure, LossFactorError(at=Members((4,)), factor=factor)).modes().elastic(6)
    # first order in damping: what is left out is its square, 1e-8, over the spacing of modes
    np.testing.assert_allclose(found.loss_factors, 1e-4 * (1 + (factor - 1) * share), rtol=1e-6)
    assert share.max() > 0.05


@pytest.mark.parametrize("factor", [0.0, 0.3, 4.0])
def test_everywhere_it_multiplies_what_goes_with_stiffness_and_leaves_what_goes_with_mass(
    factor: float,
) -> None:
    found = applied(steel_beam(), LossFactorError(factor=factor)).modes().elastic(8)
    # eta_r = a / lambda_r + b, 1992 thesis, chapter 5
    exact = MASS_PART / found.eigenvalues.real + factor * ETA
    np.testing.assert_allclose(found.loss_factors, exact, rtol=1e-6)  # rounding of eigenvalues


LAWS: tuple[Damping, ...] = (
    StructuralDamping(ETA, MASS_PART),
    ViscousDamping(2e-6, 3.0),
    ModalDamping((0.01, 0.02, 0.005)),
)


@pytest.mark.parametrize("law", LAWS, ids=["structural", "viscous", "modal"])
def test_everywhere_it_is_the_model_with_another_damping_law(law: Damping) -> None:
    effect = LossFactorError(factor=2.5)
    expected = {
        StructuralDamping: StructuralDamping(2.5 * ETA, MASS_PART),
        ViscousDamping: ViscousDamping(2.5 * 2e-6, 3.0),
        ModalDamping: ModalDamping((0.025, 0.05, 0.0125)),
    }[type(law)]
    assert effect.added_to(steel_beam(law)).damping == expected
    system = assemble(steel_beam(expected))
    pick = system.selection(dofs(1, 7))
    exact = direct_receptance(system, FREQ, pick, pick)
    found = receptance(applied(steel_beam(law), effect), FREQ, pick, pick)
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-9 * np.abs(exact).max())  # rounding


def test_at_a_member_it_is_the_model_whose_member_has_that_loss_factor() -> None:
    structure = change(steel_beam(), [MemberChange((4, 9), MemberProperty.LOSS_FACTOR, value=0.03)])
    system = assemble(structure)
    pick = system.selection(dofs(1, 7))
    exact = direct_receptance(system, FREQ, pick, pick)
    effect = LossFactorError(at=Members((4, 9)), factor=0.03 / ETA)
    np.testing.assert_allclose(receptance(applied(steel_beam(), effect), FREQ, pick, pick), exact, rtol=1e-6)
    assert {
        m.number for m in effect.added_to(steel_beam()).members if m.loss_factor == pytest.approx(0.03)
    } == {4, 9}


def test_of_a_viscous_model_a_members_own_share_is_multiplied() -> None:
    law = ViscousDamping(2e-6, 3.0)
    loaded = applied(steel_beam(law), LossFactorError(at=Members((4,)), factor=3.0)).folded()
    bare = assemble(steel_beam(law))
    assert loaded.viscous is not None
    assert bare.viscous is not None
    assert bare.members is not None
    kept = bare.members.rows[3] >= 0
    expected = bare.viscous.toarray()
    rows = bare.members.rows[3][kept]
    expected[np.ix_(rows, rows)] += 2 * 2e-6 * bare.members.bending[3][np.ix_(kept, kept)]
    np.testing.assert_allclose(loaded.viscous.toarray(), expected, atol=1e-12 * expected.max())


def test_everywhere_modes_are_not_solved_for_again_and_one_member_is_two_columns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system = assemble(steel_beam())
    system.base_modes(800.0)
    monkeypatch.setattr("modallab.fe.system_matrices.undamped_basis", None)  # calling it would raise
    chain(system, rig(1, 7), [LossFactorError(factor=3.0)]).respond(FREQ)
    one = LossFactorError(at=Members((4,)), factor=3.0).on_system(system, SHOT)
    assert one.stacked_columns.shape[1] == 2  # a beam strains in two ways
    chain(system, rig(1, 7), [LossFactorError(at=Members((4,)), factor=3.0)]).respond(FREQ)


def test_it_acts_on_the_stiffness_that_another_effect_has_changed() -> None:
    system = assemble(steel_beam(StructuralDamping(ETA)))
    effect = LossFactorError(at=Members((4,)), factor=3.0)
    one = effect.on_system(system.change_member(4, bending=0.5), SHOT).folded()
    other = effect.on_system(system, SHOT).change_member(4, bending=0.5).folded()
    assert one.damping is not None
    assert other.damping is not None
    assert system.members is not None
    extra = (one.damping - system.damping).toarray()
    kept = system.members.rows[3] >= 0
    rows = system.members.rows[3][kept]
    # 3 eta 1.5 K in place of eta K
    expected = (4.5 - 1) * ETA * system.members.bending[3][np.ix_(kept, kept)]
    np.testing.assert_allclose(extra[np.ix_(rows, rows)], expected, atol=1e-9 * expected.max())
    np.testing.assert_allclose(one.damping.toarray(), other.damping.toarray(), atol=1e-9 * expected.max())


def test_modal_damping_belongs_to_no_member() -> None:
    structure = steel_beam(ModalDamping((0.01,)))
    with pytest.raises(InvalidInputError) as caught:
        LossFactorError(at=Members((4,))).check(structure)
    assert caught.value.context["field"] == "at"
    LossFactorError().check(structure)
    assert LossFactorError.places(assemble(structure), rig(1)) == (None,)
    own = replace(structure, members=(replace(structure.members[0], loss_factor=0.1), *structure.members[1:]))
    assert LossFactorError.places(assemble(own), rig(1)) == (None, Members((1,)))


def test_of_a_model_without_loss_there_is_nothing_to_multiply() -> None:
    assert LossFactorError.places(assemble(steel_beam(StructuralDamping())), rig(1)) == ()

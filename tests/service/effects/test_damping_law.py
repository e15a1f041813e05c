"""Damping by another law, held against the two laws themselves and against loss factors in closed form."""

import numpy as np
import pytest

from modallab.effects.damping_law import DampingLaw
from modallab.fe.assembly import assemble
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance, receptance
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests.rigs import dofs, rig, steel_beam

SHOT = AcquisitionRun(dofs(1), dofs(1))
AT = 200.0  # Hz
OMEGA = 2 * np.pi * AT
FREQ = np.linspace(10.0, 700.0, 40)
HYSTERETIC, VISCOUS = StructuralDamping(0.005, 100.0), ViscousDamping(0.005 / OMEGA, 100.0 / OMEGA)
MODAL = ModalDamping((0.01, 0.02, 0.005))
LAWS: tuple[Damping, ...] = (HYSTERETIC, VISCOUS, MODAL)
IDS = ["structural", "viscous", "modal"]


@pytest.mark.parametrize(
    ("model", "truth"), [(HYSTERETIC, VISCOUS), (VISCOUS, HYSTERETIC)], ids=["to", "from"]
)
def test_all_of_it_is_the_other_law_alike_at_the_reference_frequency(model: Damping, truth: Damping) -> None:
    exact_system = assemble(steel_beam(truth))
    pick = exact_system.selection(dofs(1, 7))
    exact = direct_receptance(exact_system, FREQ, pick, pick)
    loaded = DampingLaw(share=1.0, frequency=AT).on_system(assemble(steel_beam(model)), SHOT)
    found = receptance(loaded, FREQ, pick, pick)
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-9 * np.abs(exact).max())  # rounding


@pytest.mark.parametrize("law", LAWS, ids=IDS)
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_a_modes_loss_factor_leans_on_its_frequency_by_the_share(law: Damping, share: float) -> None:
    system = assemble(steel_beam(law))
    bare = system.modes().elastic(8)
    found = DampingLaw(share=share, frequency=AT).on_system(system, SHOT).modes().elastic(8)
    ratio = bare.frequencies / AT  # viscous loss over hysteretic loss
    lean = 1 - share + share / ratio if isinstance(law, ViscousDamping) else 1 - share + share * ratio
    np.testing.assert_allclose(found.loss_factors, bare.loss_factors * lean, rtol=1e-6)  # rounding
    np.testing.assert_allclose(found.frequencies, bare.frequencies, rtol=1e-6)


@pytest.mark.parametrize("law", LAWS, ids=IDS)
def test_at_the_reference_frequency_nothing_changes(law: Damping) -> None:
    system = assemble(steel_beam(law))
    pick = system.selection(dofs(1, 7, 16))
    loaded = DampingLaw(share=0.7, frequency=AT).on_system(system, SHOT)
    there, beside = np.array([AT]), np.array([1.3 * AT])
    found, bare = (receptance(one, there, pick, pick) for one in (loaded, system))
    np.testing.assert_allclose(found, bare, rtol=1e-9)  # (1 - s) + s = 1
    found, bare = (receptance(one, beside, pick, pick) for one in (loaded, system))
    assert np.abs(found / bare - 1).max() > 1e-4


@pytest.mark.parametrize("law", LAWS, ids=IDS)
def test_modes_are_not_solved_for_again(law: Damping, monkeypatch: pytest.MonkeyPatch) -> None:
    system = assemble(steel_beam(law))
    system.base_modes(800.0)
    monkeypatch.setattr("modallab.fe.system_matrices.undamped_basis", None)  # calling it would raise
    chain(system, rig(1, 7), [DampingLaw()]).respond(FREQ)


def test_a_member_that_is_changed_follows_the_mixed_law() -> None:
    system = assemble(steel_beam(HYSTERETIC))
    effect = DampingLaw(share=0.4, frequency=AT)
    loaded = effect.on_system(system, SHOT).change_member(4, mass=0.3, bending=0.5).folded()
    changed = system.change_member(4, mass=0.3, bending=0.5).folded()
    assert loaded.damping is not None
    assert loaded.viscous is not None
    assert changed.damping is not None
    whole = changed.damping.toarray()
    size = np.abs(whole).max()
    np.testing.assert_allclose(loaded.damping.toarray(), 0.6 * whole, atol=1e-10 * size)
    np.testing.assert_allclose(loaded.viscous.toarray() * OMEGA, 0.4 * whole, atol=1e-10 * size)


def test_a_structure_without_loss_follows_no_law() -> None:
    assert DampingLaw.places(assemble(steel_beam(StructuralDamping())), rig(1)) == ()


@pytest.mark.parametrize(("law", "frequency"), [(HYSTERETIC, 1e5), (VISCOUS, 0.5)], ids=["above", "below"])
def test_far_outside_the_band_it_is_a_wrong_loss_factor(law: Damping, frequency: float) -> None:
    effect = DampingLaw(share=0.6, frequency=frequency)
    (limit,) = effect.limiting_effects()
    assert (limit.kind, limit.parameters) == ("loss_factor_error", {"factor": 0.4})
    system = assemble(steel_beam(law))
    found, alone, bare = (
        chain(system, rig(1, 7, 16), effects).respond(FREQ).inertance for effects in ([effect], [limit], [])
    )
    # The other law dissipates at most 700 / 1e5 or 0.5 / 10 of what it would at its reference frequency.
    assert np.linalg.norm(found - alone) < 0.1 * np.linalg.norm(bare - alone)

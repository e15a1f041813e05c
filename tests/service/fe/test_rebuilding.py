"""Systems whose members are others: what need not be solved for again."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import GroundStiffness, MemberChange, MemberProperty, change
from modallab.fe.damping import ModalDamping, StructuralDamping
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Material, Section, Structure

FREQ = np.array([5.0, 33.0, 155.0, 390.0, 800.0])


def long_beam() -> Structure:
    """So many DoFs that it is solved for up to a frequency."""
    return beam(
        length=1.5,
        n_elements=EIGENSOLUTION.dense_dofs // 2 + 10,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(0.01, 50.0),
    )


@pytest.mark.parametrize("factor", [0.7, 0.99, 1.3])
def test_modes_of_a_stretched_large_system_are_those_of_another_material(
    factor: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    structure = long_beam()
    system = assemble(structure)
    system.base_modes(1.25 * FREQ.max())
    monkeypatch.setattr("modallab.fe.system_matrices.undamped_basis", None)  # calling it would raise
    every = tuple(member.number for member in structure.members)
    exact_system = assemble(change(structure, [MemberChange(every, MemberProperty.MODULUS, factor=factor)]))
    pick = system.selection((Dof(1, "Y"), Dof(40, "Y")))
    exact = direct_receptance(exact_system, FREQ, pick, pick)
    found = receptance(system.scaled(stiffness=factor), FREQ, pick, pick)
    # the series of the modes above ends at (800/1600)^8, and their damping is left out
    np.testing.assert_allclose(found, exact, rtol=1e-2)


def test_softening_bit_by_bit_asks_for_one_wider_band_only(monkeypatch: pytest.MonkeyPatch) -> None:
    system = assemble(long_beam())
    system.scaled(stiffness=0.99).base_modes(800.0)
    monkeypatch.setattr("modallab.fe.system_matrices.undamped_basis", None)
    for factor in (0.98, 0.9, 0.7):
        system.scaled(stiffness=factor).base_modes(800.0)


def test_springs_to_the_ground_do_not_stretch() -> None:
    structure = change(STRUCTURES["chapter-5-beam"](), [GroundStiffness(Dof(3, "Y"), 1e4)])
    every = tuple(member.number for member in structure.members)
    softer = assemble(change(structure, [MemberChange(every, MemberProperty.MODULUS, factor=0.8)]))
    found = assemble(structure).scaled(stiffness=0.8).modes()
    np.testing.assert_allclose(found.frequencies[2:], softer.modes().frequencies[2:], rtol=1e-7)  # rounding


def test_modal_damping_is_of_the_bare_structure_whatever_hangs_on_it() -> None:
    structure = replace(STRUCTURES["chapter-5-beam"](), damping=ModalDamping((0.01, 0.02, 0.03)))
    bare = assemble(structure)
    basis = bare.modes().elastic()
    etas = np.array([0.01, 0.02, *([0.03] * (len(basis.frequencies) - 2))])
    # D = M Phi diag(eta lambda) Phi^T M, written out
    reach = bare.mass @ basis.shapes.real
    damping = reach @ np.diag(etas * basis.eigenvalues.real) @ reach.T
    loaded = bare.add_mass(3, 0.2)
    pick = loaded.selection((Dof(1, "Y"), Dof(7, "Y")))
    mass, stiffness = (part.toarray() for part in (loaded.folded().mass, loaded.folded().stiffness))
    z = np.array([stiffness + 1j * damping - (2 * np.pi * f) ** 2 * mass for f in FREQ])
    exact = pick.T @ np.linalg.solve(z, pick + 0j)
    # rounding: the largest of eigenvalues stands 1e6 above the first
    for found in (receptance(loaded, FREQ, pick, pick), direct_receptance(loaded, FREQ, pick, pick)):
        np.testing.assert_allclose(found, exact, rtol=1e-7)
    np.testing.assert_allclose(bare.resonances(800.0)[1][:3], (etas * basis.frequencies)[:3] / 2, rtol=1e-9)


def test_structures_with_other_members_share_the_masses_attached_to_their_dofs() -> None:
    structure = STRUCTURES["cantilever"]()
    system = assemble(structure)
    stiffer = system.with_member_factors(stiffness=(1.1,) * len(structure.members), mass=())
    masses = [each.add_mass(3, 0.1).attachments[-1] for each in (system, stiffer)]
    assert stiffer.cache is not system.cache
    assert masses[0] is masses[1]

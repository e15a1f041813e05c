"""A structure that changes from run to run, held against models of the changed modulus."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.drift import Drift
from modallab.fe.assembly import assemble
from modallab.fe.changes import GroundStiffness, MemberChange, MemberProperty, change
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import Structure
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers
from tests.rigs import dofs, rig, steel_beam

NODES = (1, 5, 9, 13, 21)
ROVING = rig(*NODES, accelerometers=Accelerometers(mass=0.01, roving=True))
FREQ = np.linspace(10.0, 700.0, 40)
EVERY = tuple(range(1, 21))


def with_spring(structure: Structure) -> Structure:
    return change(structure, [GroundStiffness(Dof(3, "Y"), 2e4)])


def test_natural_frequencies_follow_the_square_root_of_the_modulus() -> None:
    change_of = -0.04
    system = assemble(steel_beam(StructuralDamping(0.005)))
    bare = system.modes().elastic(8)
    for i, run in enumerate(
        chain(system, rig(*NODES, accelerometers=Accelerometers(roving=True)), [Drift(change=change_of)]).runs
    ):
        exact = bare.frequencies * np.sqrt(1 + change_of * i / 4)
        np.testing.assert_allclose(run.system.modes().elastic(8).frequencies, exact, rtol=1e-9)


LAWS: tuple[Damping, ...] = (
    StructuralDamping(0.005, 100.0),
    ViscousDamping(2e-6, 3.0),
    ModalDamping((0.01, 0.02, 0.005)),
)


@pytest.mark.parametrize("law", LAWS, ids=["structural", "viscous", "modal"])
@pytest.mark.parametrize("grounded", [False, True], ids=["free", "on a spring"])
def test_each_run_is_a_test_of_a_structure_of_that_modulus(law: Damping, grounded: bool) -> None:
    structure = with_spring(steel_beam(law)) if grounded else steel_beam(law)
    bench = chain(assemble(structure), ROVING, [Drift(change=0.1)])
    found = bench.respond(FREQ).inertance[:, :, 0, 0]
    for i, node in enumerate(NODES):
        stiffer = change(structure, [MemberChange(EVERY, MemberProperty.MODULUS, factor=1 + 0.1 * i / 4)])
        system = assemble(stiffer).add_mass(node, 0.01)
        left, right = system.selection(dofs(node)), system.selection(dofs(1))
        exact = -((2 * np.pi * FREQ) ** 2) * direct_receptance(system, FREQ, left, right)[:, 0, 0]
        np.testing.assert_allclose(found[i], exact, rtol=1e-6, atol=1e-9 * np.abs(exact).max())  # rounding


def test_modes_are_solved_for_once_for_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    system = assemble(steel_beam())
    system.base_modes(800.0)
    monkeypatch.setattr("modallab.fe.system_matrices.undamped_basis", None)  # calling it would raise
    chain(system, ROVING, [Drift(change=0.05)]).respond(FREQ)


def test_a_test_of_one_run_does_not_see_it() -> None:
    system, setup = assemble(steel_beam()), rig(1, 7, 16)
    assert Drift.places(system, setup) == ()
    assert Drift.places(system, ROVING) == (None,)
    bare, drifting = (chain(system, setup, added).respond(FREQ) for added in ([], [Drift(change=0.2)]))
    assert bare.response.tobytes() == drifting.response.tobytes()

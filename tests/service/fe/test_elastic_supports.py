"""A held DoF on a spring is what a model without that support, but with the spring, has there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import UnknownDofError
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.imported_elements import GroupMatrices, of_groups
from modallab.fe.plate import plate
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.structure import PLANE, Material, Member, PointMass, Structure, Support
from modallab.fe.system import DynamicSystem
from tests.rigs import BAR, STEEL, steel_beam

FREQ = np.linspace(5.0, 400.0, 37)
BEAM = replace(steel_beam(n_elements=8, masses=(PointMass(1, 0.3), PointMass(6, 0.1))), supports=())
FRAME = Structure(
    nodes={1: (0.0, 0.0), 2: (0.0, 0.4), 3: (0.3, 0.7), 4: (0.8, 0.4), 5: (0.8, 0.0), 6: (0.4, 0.4)},
    members=tuple(
        Member(i, pair, BAR, STEEL)
        for i, pair in enumerate([(1, 2), (2, 3), (3, 4), (4, 5), (2, 6), (6, 4)], 1)
    ),
    damping=ViscousDamping(stiffness_coefficient=1e-5, mass_coefficient=3.0),
)
PLATE = plate(
    length=0.6,
    width=0.4,
    thickness=0.004,
    n_elements=(3, 2),
    material=Material(2e11, 7800.0),
    damping=StructuralDamping(0.01),
)
Held = dict[int, tuple[str, ...]]
CASES: dict[str, tuple[Structure, Held, dict[str, float]]] = {
    "clamped end": (BEAM, {1: ("Y", "RZ")}, {"1:+RZ": 1e-4}),
    "clamped end, along and about": (BEAM, {1: ("Y", "RZ")}, {"1:+RZ": 1e-4, "1:+Y": 1e-6}),
    "support at mid-span": (BEAM, {1: ("Y", "RZ"), 5: ("Y",)}, {"5:+Y": 3e-6}),
    "both ends of a member": (BEAM, {4: ("Y",), 5: ("RZ",)}, {"4:+Y": 3e-6, "5:+RZ": 1e-3}),
    "feet of a frame": (FRAME, {1: PLANE, 5: PLANE}, {"1:+RZ": 1e-3, "5:+X": 1e-7, "5:+Y": 1e-6}),
    "corner of members": (FRAME, {4: PLANE, 1: ("X", "Y")}, {"4:+RZ": 1e-3, "4:+X": 1e-6}),
    "edge of a plate": (PLATE, {1: ("Z",), 5: ("Z", "RX"), 9: ("Z",)}, {"5:+Z": 1e-5, "5:+RX": 1e-2}),
}


def softened(system: DynamicSystem, flexibilities: dict[str, float]) -> DynamicSystem:
    for at, flexibility in flexibilities.items():
        system = system.soften_support(Dof.parse(at), flexibility)
    return system


def sprung(free: Structure, held: Held, flexibilities: dict[str, float]) -> DynamicSystem:
    """The same structure without those supports, and springs to the ground in their place."""
    soft = {Dof.parse(at) for at in flexibilities}
    directions = {node: tuple(d for d in names if Dof(node, d) not in soft) for node, names in held.items()}
    system = assemble(replace(free, supports=tuple(Support(n, d) for n, d in directions.items())))
    for at, flexibility in flexibilities.items():
        system = system.add_spring(Dof.parse(at), 1 / flexibility)
    return system


def at_all(system: DynamicSystem, dofs: tuple[Dof, ...]) -> ComplexArray:
    points = system.selection(dofs)
    return receptance(system, FREQ, points, points[:, :3])


def same(found: DynamicSystem, wanted: DynamicSystem) -> None:
    """Receptances at every DoF of the first; of matrices without joints by a solution at every line."""
    points = wanted.selection(found.dofs)
    joined = any(attachment.inner for attachment in wanted.attachments)
    solved = receptance if joined else direct_receptance
    exact = solved(wanted, FREQ, points, points[:, :3])
    # rounding of eigenvalues, 1e-16 times their ratio of up to 1e9, over a loss factor of 0.005 at resonance
    np.testing.assert_allclose(at_all(found, found.dofs), exact, rtol=2e-5, atol=1e-8 * np.abs(exact).max())


@pytest.mark.parametrize("case", CASES)
def test_receptances_are_those_of_a_model_with_springs_in_place_of_the_supports(case: str) -> None:
    free, held, flexibilities = CASES[case]
    clamped = replace(free, supports=tuple(Support(n, d) for n, d in held.items()))
    same(softened(assemble(clamped), flexibilities), sprung(free, held, flexibilities))


@pytest.mark.parametrize("case", ["clamped end", "feet of a frame", "edge of a plate"])
@pytest.mark.parametrize(
    "change",
    [
        lambda system: system.scaled(mass=1.1, stiffness=0.8),
        lambda system: system.change_member(1, mass=0.2, bending=-0.3),
        lambda system: system.change_member(6, mass=0.2, bending=-0.3),
        lambda system: system.converted(0.5, 300.0),
    ],
    ids=["all members", "a member there", "a member elsewhere", "damping law"],
)
def test_changes_of_members_act_before_and_after_alike(
    case: str, change: Callable[[DynamicSystem], DynamicSystem]
) -> None:
    free, held, flexibilities = CASES[case]
    clamped = assemble(replace(free, supports=tuple(Support(n, d) for n, d in held.items())))
    wanted = change(sprung(free, held, flexibilities))
    same(change(softened(clamped, flexibilities)), wanted)
    same(softened(change(clamped), flexibilities), wanted)


@pytest.mark.parametrize("flexibility", [1e-9, 1e-2])
def test_a_joint_in_the_member_at_the_support_counts(flexibility: float) -> None:
    free, held, flexibilities = CASES["clamped end, along and about"]
    clamped = assemble(replace(free, supports=(Support(1, held[1]),)))
    wanted = sprung(free, held, flexibilities).add_joint(2, flexibility)
    same(softened(clamped, flexibilities).add_joint(2, flexibility), wanted)
    same(softened(clamped.add_joint(2, flexibility), flexibilities), wanted)


@pytest.mark.parametrize("flexibility", [0.0, 1e-20])
def test_a_rigid_support_is_a_regular_limit(flexibility: float) -> None:
    free, held, _ = CASES["clamped end"]
    clamped = assemble(replace(free, supports=(Support(1, held[1]),)))
    found, wanted = (at_all(s, clamped.dofs) for s in (softened(clamped, {"1:+RZ": flexibility}), clamped))
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())  # rounding


def test_flexibilities_at_one_dof_add_like_springs_in_series() -> None:
    free, held, _ = CASES["clamped end"]
    clamped = assemble(replace(free, supports=(Support(1, held[1]),)))
    twice = softened(softened(clamped, {"1:+RZ": 1e-4}), {"1:+RZ": 3e-4})
    same(twice, sprung(free, held, {"1:+RZ": 4e-4}))
    assert len(twice.attachments) == 1


def test_the_modes_are_those_of_the_model_with_springs() -> None:
    free, held, flexibilities = CASES["feet of a frame"]
    clamped = assemble(replace(free, supports=tuple(Support(n, d) for n, d in held.items())))
    found, wanted = (
        system.modes(500.0).frequencies[:4]
        for system in (softened(clamped, flexibilities), sprung(free, held, flexibilities))
    )
    np.testing.assert_allclose(found, wanted, rtol=1e-8)  # rounding of two eigensolutions


def test_imported_matrices_know_what_is_held() -> None:
    system = assemble(PLATE)
    imported = of_groups([GroupMatrices("all", system.mass, system.stiffness)], PLATE.dofs)
    clamped = replace(imported, supports=(Support(1, ("Z",)), Support(5, ("Z",)), Support(4, ("Z",))))
    assert clamped.held_dofs == (Dof(1, "Z"), Dof(5, "Z"), Dof(4, "Z"))
    found = assemble(clamped).soften_support(Dof(5, "Z"), 1e-5)
    wanted = assemble(replace(clamped, supports=(clamped.supports[0], clamped.supports[2])))
    same(found, wanted.add_spring(Dof(5, "Z"), 1e5))


def test_what_no_support_holds_is_refused_with_what_is_held() -> None:
    clamped = assemble(replace(BEAM, supports=(Support(1, ("X", "Y", "RZ")),)))
    for at in ("1:+X", "2:+Y", "99:+Y"):  # the beam has no X
        with pytest.raises(UnknownDofError) as caught:
            clamped.soften_support(Dof.parse(at), 1e-6)
        assert caught.value.context["allowed"] == ["1:+Y", "1:+RZ"]

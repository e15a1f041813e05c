"""Joints that a model has are found by their stiffness."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, StructureError
from modallab.core.frf import FrfKind, FrfSet
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping
from modallab.fe.modes import modal_basis
from modallab.fe.structure import JointSpring, Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.exact import as_modelled, with_effects
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.method import UPDATERS
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import Part, at_nodes, parameterise
from modallab.updating.responses.method import RESPONSE_UPDATERS
from tests.service.updating.cases import BAY_DOFS, BEAM_DOFS, modes_of
from tests.service.updating.responses.cases import exact

BEAM = replace(STRUCTURES["chapter-5-beam"](), damping=StructuralDamping())
# A member's end is turned by 4 E I / L = 4.6e4 N m/rad.
MODEL = replace(BEAM, joints=(JointSpring(6, 2e4), JointSpring(14, 1e5)))
TRUTH = replace(BEAM, joints=(JointSpring(6, 1.2e4), JointSpring(14, 1e5)))
# At node 5 of the bay member 4 ends, at node 1 it has members that start: of one both ends are loose.
BAY = replace(STRUCTURES["bay"](), joints=tuple(JointSpring(node, 4e8) for node in (1, 2, 5, 13)))
GROUPS = [tuple(range(first, first + 4)) for first in range(1, 21, 4)]
EXACT = 1e-6  # noise-free modes: rounding, times the condition of the equations


def receptance(system: DynamicSystem, freq: FloatArray) -> ComplexArray:
    """Return the receptances of a system's DoFs, (n_freq, n, n), by the inverse of its dynamic stiffness."""
    system, n = system.folded() if system.attachments else system, len(system.dofs)
    lost, slow = (0.0 if one is None else one.toarray() for one in (system.damping, system.viscous))
    w = 2 * np.pi * freq[:, None, None]
    z = system.stiffness.toarray() - w**2 * system.mass.toarray() + 1j * lost + 1j * w * slow
    return np.linalg.inv(z)[:, :n, :n]


@pytest.mark.parametrize("law", [StructuralDamping(0.02, 30.0), ViscousDamping(1e-6, 2.0)])
@pytest.mark.parametrize("structure", [MODEL, BAY], ids=["beam", "bay"])
def test_jumps_as_rows_are_those_that_hang_on_a_system(structure: Structure, law: Damping) -> None:
    lossy = replace(structure, damping=law)
    ours, hung = Assembly(lossy, joint_rotations=True).system(), assemble(lossy)
    assert ours.mass.shape == (len(structure.dofs) + len(structure.joints),) * 2
    found, own = (receptance(system, np.linspace(5.0, 300.0, 7)) for system in (ours, hung))
    # rounding, times the condition of the dynamic stiffness
    np.testing.assert_allclose(found, own, rtol=0, atol=1e-8 * np.abs(own).max())


def test_a_joint_lowers_frequencies_and_a_stiff_one_none() -> None:
    own, loose, stiff = (
        modal_basis(s.mass, s.stiffness, None, None, s.rigid, frequency_max=np.inf).frequencies[2:8]
        for s in (
            Assembly(replace(BEAM, joints=joints), joint_rotations=True).system()
            for joints in ((), (JointSpring(11, 1e3),), (JointSpring(11, 1e12),))
        )
    )
    assert (loose <= own * (1 + 1e-12)).all()
    assert loose[0] < 0.95 * own[0]
    np.testing.assert_allclose(stiff, own, rtol=1e-6)  # E I / L over the joint: 1e-8, and rounding


PARTS = ("joint_stiffness", "area", "second_moment", "density", "damping", "mass", "modulus")


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("damped", [False, True])
def test_derivatives_are_those_of_the_matrices(part: str, damped: bool) -> None:
    if part == "damping" and not damped:
        return
    lossy = replace(MODEL, damping=StructuralDamping(0.02))
    also = at_nodes(lossy, {"joint_stiffness": None})
    members = () if part == "joint_stiffness" else ((5,), (6, 7), (13,))
    parameters = parameterise(members, () if not members else (part,), nodal=also)
    model = CorrectedModel(Assembly(lossy, joint_rotations=True), parameters)
    at = parameters.nominal + np.linspace(0.1, 0.3, len(parameters.macros))
    found = {Part.MASS: np.zeros((len(at), model.size, model.size), complex)}
    found[Part.STIFFNESS] = found[Part.MASS].copy()
    for one in model.parts(at, damped=damped):
        kind = Part.MASS if one.part is Part.MASS else Part.STIFFNESS
        owner = np.repeat(one.params, np.diff(one.starts))
        for matrix, rows, param in zip(one.matrices, one.rows, owner, strict=True):
            kept = np.flatnonzero(rows >= 0)
            found[kind][(param, *np.ix_(rows[kept], rows[kept]))] += matrix[np.ix_(kept, kept)]

    def matrices(values: FloatArray) -> tuple[Any, Any]:
        system = model.system(values)
        lost = 0.0 if not damped or system.damping is None else 1j * system.damping.toarray()
        return system.mass.toarray(), system.stiffness.toarray() + lost

    step = 1e-6
    for i in range(len(at)):
        aside = step * (np.arange(len(at)) == i)
        pairs = zip(matrices(at + aside), matrices(at - aside), strict=True)
        for kind, (more, less) in zip((Part.MASS, Part.STIFFNESS), pairs, strict=True):
            slope = (more - less) / (2 * step)
            # central differences: rounding over the step, and the square of it
            size = np.abs(more).max()
            np.testing.assert_allclose(found[kind][i], slope, rtol=0, atol=1e-8 * size)


@pytest.mark.parametrize("groups", [[], GROUPS], ids=["alone", "with mass and stiffness of members"])
@pytest.mark.parametrize("method", [name for name in UPDATERS if not name.startswith("complex")])
def test_a_joint_is_found_in_its_unit(method: str, groups: Sequence[tuple[int, ...]]) -> None:
    parameters = parameterise(groups, nodal=at_nodes(MODEL, {"joint_stiffness": None}))
    options = UpdateOptions(tolerance=1e-9)
    result = UPDATERS[method](MODEL, parameters, modes_of(TRUTH, 8, BEAM_DOFS), options=options)
    assert result.coefficients["joint_stiffness"][6] == pytest.approx(0.6, abs=EXACT)
    told = {(one.part.value, one.members): one for one in result.quantities}
    found = told["joint_stiffness", (6,)]
    assert (found.before, found.unit) == (2e4, "N m/rad")
    assert found.after == pytest.approx(1.2e4, rel=EXACT)
    assert [one.stiffness for one in result.structure.joints] == pytest.approx([1.2e4, 1e5], rel=EXACT)


@pytest.mark.parametrize("method", ["complex_inverse_eigensensitivity", "complex_one_shot"])
def test_a_joint_is_found_from_damped_modes_with_what_members_lose(method: str) -> None:
    model = replace(MODEL, damping=StructuralDamping(0.02))
    members = tuple(replace(m, loss_factor=0.08) if m.number == 5 else m for m in BEAM.members)
    truth = replace(TRUTH, damping=model.damping, members=members)
    also = at_nodes(model, {"joint_stiffness": None})
    parameters = parameterise([(4,), (5,), (6,)], ("damping",), nodal=also)
    options = UpdateOptions(tolerance=1e-9)
    result = UPDATERS[method](model, parameters, modes_of(truth, 8, BEAM_DOFS), options=options)
    assert result.coefficients["joint_stiffness"][6] == pytest.approx(0.6, abs=EXACT)
    assert result.coefficients["damping"][5] == pytest.approx(0.06, abs=EXACT)


def test_a_joint_is_found_on_responses() -> None:
    model, truth = (replace(one, damping=StructuralDamping(0.02)) for one in (MODEL, TRUTH))
    freq, rows = np.linspace(10.0, 800.0, 80), [truth.index(dof) for dof in BEAM_DOFS]
    values = receptance(assemble(truth), freq)[:, rows, :1]  # driven at 1:+Y
    target = exact(FrfSet(freq, values, BEAM_DOFS, BEAM_DOFS[:1], FrfKind.RECEPTANCE))
    parameters = parameterise(GROUPS, ("stiffness",), nodal=at_nodes(model, {"joint_stiffness": None}))
    result = RESPONSE_UPDATERS["frf_residual"](model, parameters, target)
    assert result.coefficients["joint_stiffness"] == pytest.approx({6: 0.6, 14: 1.0}, abs=EXACT)


def test_joints_of_a_frame_are_found_among_its_members() -> None:
    truth = replace(
        BAY, joints=(JointSpring(1, 4e8), JointSpring(2, 4e8), JointSpring(5, 2e8), JointSpring(13, 4e8))
    )
    also = at_nodes(BAY, {"joint_stiffness": None})
    parameters = parameterise([(m.number,) for m in BAY.members], ("bending",), nodal=also)
    target = modes_of(truth, 10, BAY_DOFS)
    result = UPDATERS["one_shot"](BAY, parameters, target, options=UpdateOptions(tolerance=1e-9))
    assert result.suspected["joint_stiffness"] == (5,)
    assert result.coefficients["joint_stiffness"][5] == pytest.approx(0.5, abs=1e-5)


def test_an_effect_that_is_a_joint_is_one_of_the_models() -> None:
    effect = JointFlexibility(at=Dof(11, "RZ"), flexibility=5e-5)
    model = with_effects(replace(MODEL, effects=(effect.spec,)))
    assert (model.effects, model.joints[-1].node) == ((), 11)
    assert model.joints[-1].stiffness == pytest.approx(2e4)
    assert effect.added_to(model).joints[-1].stiffness == pytest.approx(1e4)
    assert JointFlexibility(at=Dof(11, "RZ"), flexibility=0.0).added_to(MODEL) is MODEL
    found, own = (as_modelled(one) for one in (model, replace(MODEL, effects=(effect.spec,))))
    freq = np.linspace(5.0, 300.0, 7)
    one, other = receptance(found, freq), receptance(own, freq)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize("joints", [(JointSpring(1, 1e4),), (JointSpring(6, 1e4), JointSpring(6, 2e4))])
def test_a_joint_is_where_two_bars_meet_and_once(joints: tuple[JointSpring, ...]) -> None:
    with pytest.raises(StructureError, match="no joint at node") as caught:
        replace(BEAM, joints=joints)
    assert caught.value.context["field"] == "joints"


def test_a_node_without_a_joint_has_no_coefficient() -> None:
    with pytest.raises(InvalidInputError, match="node 7 carries no joint stiffness"):
        parameterise([], nodal=at_nodes(MODEL, {"joint_stiffness": [(7,)]})).groups(MODEL)

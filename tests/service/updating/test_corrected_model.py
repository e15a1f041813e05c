"""A model at any coefficients is the structure that comes back, and moves as its derivatives say."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.modes import ModalBasis, modal_basis
from modallab.fe.structure import GroundSpringElement, PointMass, Structure
from modallab.fe.system import DynamicSystem
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.parameterisation import Parameterisation, Part, at_nodes, parameterise
from modallab.updating.sensitivity import PartMatrices, derivatives
from tests.service.updating.test_sensitivity import (
    BAY_DOFS,
    BEAM_DOFS,
    PLATE_DOFS,
    Case,
    near,
    plate_of,
    stepped,
)

BAY, PLATE = STRUCTURES["bay"](), plate_of(0.4, 0.3, (5, 5))
STOCKY = replace(BAY, members=tuple(replace(m, element="timoshenko") for m in BAY.members))
OF_BARS = ("density", "modulus", "area", "second_moment")
BARS = parameterise([(5,), (25, 26), (31,)], OF_BARS)
PLATES = parameterise([(1, 2), (7,), (13, 25)], ("density", "thickness", "modulus"))
MIXED = Parameterisation(
    (
        *parameterise([(3, 4)], ("thickness",)).macros,
        *parameterise([(5,), (6, 7)], ("mass", "stiffness")).macros,
    )
)
MOUNTED = replace(
    STRUCTURES["chapter-5-beam"](),
    masses=(PointMass(7, 0.05), PointMass(15, 0.1)),
    springs=(GroundSpringElement(Dof(1, "Y"), 1e5), GroundSpringElement(Dof(1, "RZ"), 100.0)),
)
MOUNTS = parameterise(
    [(1, 2, 3)],
    ("density",),
    nodal=at_nodes(MOUNTED, {"point_mass": [(7, 15)], "ground_spring_y": None, "ground_spring_rz": [(1,)]}),
)
STEP = 0.05


def somewhere(parameters: Parameterisation) -> FloatArray:
    return np.random.default_rng(2).uniform(0.7, 1.5, len(parameters.macros))


def dense(system: DynamicSystem) -> tuple[FloatArray, FloatArray]:
    return system.mass.toarray(), system.stiffness.toarray()


@dataclass(frozen=True, eq=False)
class Moved(Case):
    """A structure whose properties stand away from where they were."""

    @cached_property
    def model(self) -> CorrectedModel:
        return CorrectedModel(Assembly(self.structure), self.parameters)

    @property
    def values(self) -> FloatArray:
        return somewhere(self.parameters)

    @property
    def assembly(self) -> Assembly:
        return Assembly(self.model.structure(self.values))

    @property
    def basis(self) -> ModalBasis:
        system = self.model.system(self.values)
        return modal_basis(system.mass, system.stiffness, None, None, system.rigid)

    @property
    def parts(self) -> tuple[PartMatrices, ...]:
        return self.model.parts(self.values)

    def changes(self) -> list[tuple[FloatArray, FloatArray]]:
        """Return dM and dK of every coefficient by five points: exact of powers up to the fourth."""
        out = []
        for i in range(len(self.values)):
            aside = STEP * np.eye(len(self.values))[i]
            two, one, back, far = (
                dense(assemble(self.model.structure(self.values + k * aside))) for k in (2, 1, -1, -2)
            )
            out.append(tuple((8 * (one[j] - back[j]) - (two[j] - far[j])) / (12 * STEP) for j in (0, 1)))
        return out  # type: ignore[return-value]


CASES = {
    "bay": Moved(BAY, BARS, BAY_DOFS),
    "plate": Moved(PLATE, PLATES, PLATE_DOFS),
    "mounted beam": Moved(MOUNTED, MOUNTS, BEAM_DOFS),
    "plate, by thickness and by matrices": Moved(PLATE, MIXED, PLATE_DOFS),
}


@pytest.mark.parametrize("name", CASES)
def test_modes_move_with_properties_as_the_complex_step_says(name: str) -> None:
    case = CASES[name]
    basis = case.basis
    modes = basis.n_rigid_body + np.array([0, 1, 4])
    ours = derivatives(basis, modes, case.sensors, case.parts)
    exact = stepped(case, basis, modes)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)


@pytest.mark.parametrize(
    ("structure", "parameters"),
    [(BAY, BARS), (STOCKY, BARS), (PLATE, PLATES), (PLATE, MIXED), (MOUNTED, MOUNTS)],
)
def test_the_structure_that_comes_back_has_the_matrices_of_the_model(
    structure: Structure, parameters: Parameterisation
) -> None:
    model, values = CorrectedModel(Assembly(structure), parameters), somewhere(parameters)
    system, rebuilt = model.system(values), assemble(model.structure(values))
    for one, other in zip(dense(system), dense(rebuilt), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-14 * np.abs(other).max())
    assert system.members is not None
    assert rebuilt.members is not None
    for name in ("rigidity", "line_mass", "flexibility", "gyration"):
        ours, theirs = (getattr(one.members.shear, name) for one in (system, rebuilt))  # type: ignore[union-attr]
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_bars_that_shear_move_as_differences_say() -> None:
    case = Moved(STOCKY, BARS, BAY_DOFS)
    n = len(STOCKY.dofs)
    for i, (d_mass, d_stiffness) in enumerate(case.changes()):
        ours = {Part.MASS: np.zeros((n + 1, n + 1)), Part.STIFFNESS: np.zeros((n + 1, n + 1))}
        for part in case.parts:
            for start, stop, param in zip(part.starts[:-1], part.starts[1:], part.params, strict=True):
                for rows, matrix in zip(part.rows[start:stop], part.matrices[start:stop], strict=True):
                    if param == i:
                        ours[part.part][np.ix_(rows, rows)] += matrix.real
        for found, expected in ((ours[Part.MASS], d_mass), (ours[Part.STIFFNESS], d_stiffness)):
            size = max(np.abs(expected).max(), 1e-30)
            # of fourth order: 0.05^4 / 30 = 2e-7 of the fifth derivative, and bars shear little
            np.testing.assert_allclose(found[:n, :n] / size, expected / size, rtol=0, atol=2e-7)


def test_what_is_lost_moves_with_a_property() -> None:
    lossy = replace(PLATE, damping=StructuralDamping(0.02))
    model = CorrectedModel(Assembly(lossy), PLATES)
    values = somewhere(PLATES)
    plain, damped = model.parts(values), model.parts(values, damped=True)
    for one, other in zip(plain, damped, strict=True):
        factor = 1.0 if one.part is Part.MASS else 1 + 0.02j
        np.testing.assert_allclose(other.matrices, factor * one.matrices, rtol=1e-12)


def test_coefficients_of_matrices_alone_have_the_same_derivatives_everywhere() -> None:
    model = CorrectedModel(Assembly(BAY), parameterise([(1,), (2, 3)]))
    assert model.parts(np.ones(4)) is model.parts(np.full(4, 1.7))


def test_what_nodes_carry_loses_nothing_by_the_damping_of_members() -> None:
    lossy = replace(MOUNTED, damping=StructuralDamping(0.05, 4e4))
    model, values = CorrectedModel(Assembly(lossy), MOUNTS), somewhere(MOUNTS)

    def squares(at: FloatArray) -> ComplexArray:
        system = model.system(at)
        basis = modal_basis(system.mass, system.stiffness, system.damping, None, system.rigid)
        return np.asarray(basis.eigenvalues[basis.n_rigid_body :][:4])

    system = model.system(values)
    basis = modal_basis(system.mass, system.stiffness, system.damping, None, system.rigid)
    modes = basis.n_rigid_body + np.arange(4)
    sensors, parts = system.selection(BEAM_DOFS), model.parts(values, damped=True)
    ours = derivatives(basis, modes, sensors, parts, mass_loss=4e4).eigenvalues
    for i in range(len(values)):
        aside = 0.01 * np.eye(len(values))[i]
        two, one, back, far = (squares(values + k * aside) for k in (2, 1, -1, -2))
        moved = (8 * (one - back) - (two - far)) / 0.12
        # of fourth order: 3e-10 of fifth derivatives, and rounding of 1e-6 rad^2/s^2 over the step
        np.testing.assert_allclose(ours[:, i], moved, rtol=0, atol=2e-6 * np.abs(moved).max())

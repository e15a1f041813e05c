"""Receptances of a model and their derivatives, against other routes."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.plate import plate
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Material, Structure
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.responses import fields
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.settings import RESPONSE_PATH
from tests.service.updating.responses.cases import BEAM, exact, measured

LINES = np.array([17.0, 46.0, 160.0, 333.0])
OUTPUTS, INPUTS = (Dof(1, "Y"), Dof(9, "Y", -1)), (Dof(21, "Y"), Dof(5, "Y"))
PARTS = ("mass", "axial", "bending", "damping")
LAWS: list[Damping] = [StructuralDamping(0.01, 40.0), ViscousDamping(2e-5, 3.0)]


def model_of(structure: Structure, parameters: Parameterisation) -> ResponseModel:
    target = exact(measured(structure, LINES, OUTPUTS, INPUTS))
    return ResponseModel(CorrectedModel(Assembly(structure), parameters), target)


def stepped(structure: Structure, parameters: Parameterisation, values: ComplexArray) -> ComplexArray:
    """Receptances in complex arithmetic from element matrices, damping law by law.

    Time's imaginary unit and the step's must not mix: everything is doubled, i -> [[0, -1], [1, 0]].
    """
    assembly, n = Assembly(structure), len(structure.dofs)
    place = {member.number: k for k, member in enumerate(structure.members)}
    factors = {part: np.ones(len(place), complex) for part in PARTS[:3]} | {
        "damping": np.zeros(len(place), complex)
    }
    for macro, value in zip(parameters.macros, values, strict=True):
        for number in macro.members:
            factors[macro.part.value][place[number]] = value

    def total(each: ComplexArray) -> ComplexArray:
        out = np.zeros((n + 1, n + 1), complex)
        np.add.at(out, (assembly.rows[:, :, None], assembly.rows[:, None, :]), each)
        return out[:n, :n]

    def by(name: str) -> ComplexArray:
        return factors[name][:, None, None]

    elements = by("axial") * assembly.axial + by("bending") * assembly.bending
    mass, stiffness, lossy = (
        total(each) for each in (by("mass") * assembly.mass, elements, by("damping") * elements)
    )
    law = structure.damping
    assert isinstance(law, StructuralDamping | ViscousDamping)
    common = law.mass_coefficient * mass + law.stiffness_coefficient * stiffness
    out = []
    for omega in 2 * np.pi * LINES:
        real = stiffness - omega**2 * mass
        imaginary = lossy + common * (1.0 if isinstance(law, StructuralDamping) else omega)
        both = np.block([[real, -imaginary], [imaginary, real]])
        forces = np.zeros((2 * n, len(INPUTS)), complex)
        for k, dof in enumerate(INPUTS):
            forces[structure.index(dof), k] = dof.sign
        motion = np.linalg.solve(both, forces)
        rows = [structure.index(dof) for dof in OUTPUTS]
        sign = np.array([dof.sign for dof in OUTPUTS])[:, None]
        out.append(np.stack([sign * motion[rows], sign * motion[[n + row for row in rows]]]))
    return np.array(out)  # (n_lines, 2, n_out, n_in)


@pytest.mark.parametrize("law", LAWS)
def test_derivatives_are_those_of_the_complex_step(law: Damping) -> None:
    beam = replace(BEAM, damping=law)
    parameters = parameterise([(1, 2, 3), (9,), (14, 20)], PARTS)
    rng = np.random.default_rng(3)
    values = parameters.nominal + 0.2 * rng.uniform(-1, 1, len(parameters.macros)) * ~parameters.damping
    values = values + 0.05 * parameters.damping
    model = model_of(beam, parameters)
    (found,) = model.fields(values)
    derivatives = found.derivatives(found.driven)
    for k in range(len(values)):
        step = values.astype(complex)
        step[k] += 1e-30j
        exact_one = stepped(beam, parameters, step).imag / 1e-30
        complex_one = exact_one[:, 0] + 1j * exact_one[:, 1]
        # the size of the derivative over all lines and sensors, as a sensor may be where one is nothing
        scale = np.abs(complex_one).max()
        np.testing.assert_allclose(derivatives[..., k], complex_one, atol=1e-8 * scale + 1e-300, rtol=1e-8)


@pytest.mark.parametrize("law", LAWS)
def test_receptances_are_those_of_the_structure_solved_line_by_line(law: Damping) -> None:
    beam = replace(BEAM, damping=law)
    model = model_of(beam, parameterise([(1,)]))
    # two ways to solve the same dense equations: rounding, enlarged by their condition
    np.testing.assert_allclose(model.receptance(np.ones(2)), model.target.values, rtol=1e-7)


def test_large_models_are_solved_by_factors_and_lines_in_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = parameterise([(1, 2), (15,)])
    model = model_of(BEAM, parameters)
    values = np.array([1.1, 0.9, 1.2, 0.8])
    (dense,) = model.fields(values)
    monkeypatch.setattr(fields, "EIGENSOLUTION", replace(EIGENSOLUTION, dense_dofs=10))
    monkeypatch.setattr(fields, "RESPONSE_PATH", replace(RESPONSE_PATH, field_numbers=1))
    sparse = list(model.fields(values))
    assert len(sparse) == len(LINES)
    for k, one in enumerate(sparse):
        np.testing.assert_allclose(one.receptance[0], dense.receptance[k], rtol=1e-7)
        moved, known = one.derivatives(one.driven)[0], dense.derivatives(dense.driven)[k]
        np.testing.assert_allclose(moved, known, atol=1e-7 * np.abs(known).max())


def test_a_structure_that_lacks_a_measured_dof_is_refused() -> None:
    target = exact(measured(BEAM, LINES, OUTPUTS, INPUTS))
    lacking = replace(target, outputs=(Dof(1, "Y"), Dof(99, "Y")))
    with pytest.raises(UnknownDofError, match="99"):
        ResponseModel(CorrectedModel(Assembly(BEAM), parameterise([(1,)])), lacking)


def test_damping_of_modes_is_refused() -> None:
    beam = replace(BEAM, damping=ModalDamping((0.01,)))
    with pytest.raises(InvalidInputError, match="damping of modes"):
        ResponseModel(
            CorrectedModel(Assembly(beam), parameterise([(1,)])),
            exact(measured(BEAM, LINES, OUTPUTS, INPUTS)),
        )


@pytest.mark.parametrize("loss", [0.0, 0.01])
def test_plates_are_solved_by_pivots_on_the_diagonal_as_well_as_by_inverses(
    loss: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Others fill the factors: a line of 20,000 degrees of freedom took minutes."""
    steel, law = Material(2.09e11, 7800.0), StructuralDamping(stiffness_coefficient=loss)
    thin = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(10, 8), material=steel)
    system, resonance = (
        assemble(replace(thin, damping=law)),
        assemble(thin).modes(500.0).elastic(3).frequencies[-1],
    )
    omega = 2 * np.pi * np.array([17.0, 0.999 * resonance, 901.0])
    forces = np.random.default_rng(0).standard_normal((3, len(system.dofs), 2)).astype(complex)
    by_factors = fields.solver(system, omega)(forces)
    dense = replace(EIGENSOLUTION, dense_dofs=len(system.dofs) + 1)
    monkeypatch.setattr(fields, "EIGENSOLUTION", dense)
    # rounding, enlarged by the condition of a thin plate, 1e8
    np.testing.assert_allclose(
        by_factors, fields.solver(system, omega)(forces), atol=1e-7 * np.abs(by_factors).max()
    )

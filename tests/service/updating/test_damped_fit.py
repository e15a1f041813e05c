"""Damped models held against damped modes: derivatives, rows, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import Damping, ModalDamping, ViscousDamping
from modallab.fe.modes import modal_basis
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Structure
from modallab.updating.iteration import StopRule, iterate
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.target import complex_modes, real_modes
from tests.service.updating.cases import BAY, BAY_DOFS, BEAM, BEAM_DOFS, long_cantilever, modes_of

STEP = 2e-3  # of coefficients; errors of the extrapolated differences go with its fourth power, 2e-11
PARTS = ("mass", "axial", "bending", "damping")
JOINT = change(BAY, [MemberChange((1, 2), MemberProperty.LOSS_FACTOR, value=0.3)])
CANTILEVER = STRUCTURES["cantilever"]()  # D = aM + bK: damping that moves with the mass too
CASES = {
    "undamped bay": (BAY, parameterise([(1, 2), (12,), (25, 26)], PARTS)),
    "bay with a lossy joint": (
        JOINT,
        parameterise([(1, 2), (12,), (25, 26)], ("mass", "stiffness", "damping")),
    ),
    "free beam damped all over": (BEAM, parameterise([(1, 2), (11,)], PARTS)),
    "cantilever damped all over": (CANTILEVER, parameterise([(1, 2), (11,)], PARTS)),
}


def fit_of(structure: Structure, parameters: Parameterisation) -> ModalResiduals:
    dofs = BAY_DOFS if len(structure.members) == 31 else BEAM_DOFS[1:]
    measured = change(structure, [MemberChange((11,), MemberProperty.LOSS_FACTOR, value=0.1)])
    return ModalResiduals(Assembly(structure), parameters, complex_modes(modes_of(measured, 6, dofs)), 0.3)


def by_differences(fit: ModalResiduals, at: FloatArray) -> FloatArray:
    """Return differences of the balanced rows over coefficients, two central ones extrapolated."""
    size = fit.state(at).size[:, None]

    def central(h: float) -> FloatArray:
        columns = [fit.state(at - e).difference - fit.state(at + e).difference for e in h * np.eye(len(at))]
        return np.array(columns).T / (2 * h) / size

    return (4 * central(STEP / 2) - central(STEP)) / 3


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("where", ["as the model stands", "away from it"])
def test_derivatives_of_damped_modes_are_their_differences(case: str, where: str) -> None:
    fit = fit_of(*CASES[case])
    at = fit.parameterisation.nominal
    if where == "away from it":  # every coefficient has its effect on every other there
        at = at + np.random.default_rng(0).uniform(0.02, 0.2, len(at))
    state = fit.state(at)
    ours = fit.sensitivity(state) / state.size[:, None]
    squares = state.basis.eigenvalues.real
    # an eigenvalue is as exact as rounding of the largest one leaves it: 1e-10 of the bay's first one, 1e-8
    # of the cantilever's; the two differences of that, over their steps, add up to a few
    rounding = np.finfo(float).eps * squares.max() / squares[state.modes].min()
    np.testing.assert_allclose(ours, by_differences(fit, at), atol=1e-7 + 4 * rounding / STEP, rtol=0)
    assert rounding / STEP < 1e-5


def test_a_structure_has_the_loss_factors_that_were_found() -> None:
    fit = fit_of(BEAM, parameterise([(1, 2), (11,)], ("damping",)))
    found = fit.structure(np.array([0.2, 0.0]))
    own = BEAM.damping.stiffness_coefficient  # type: ignore[union-attr]
    assert [member.loss_factor for member in found.members[:3]] == [own + 0.2, own + 0.2, None]
    assert found.members[10].loss_factor is None  # a change of nothing


def test_a_loss_factor_below_zero_is_zero_in_the_structure_and_counted() -> None:
    fit = fit_of(BAY, parameterise([(1, 2), (11,)], ("damping",)))
    values = np.array([-0.01, 0.1])
    assert [fit.structure(values).members[i].loss_factor for i in (0, 1, 10)] == [0.0, 0.0, 0.1]
    assert fit.count_negative_loss_factors(values, 1e-4) == 2
    assert fit.count_negative_loss_factors(values, 0.02) == 0


def test_rows_are_those_of_real_modes_with_imaginary_parts_behind_them() -> None:
    parameters = parameterise([(1, 2), (12,)])
    target = modes_of(BAY, 6, BAY_DOFS)
    real = ModalResiduals(Assembly(BAY), parameters, real_modes(target), 0.3)
    damped = fit_of(BAY, parameters)
    at = np.array([1.1, 0.9, 1.2, 1.0])
    one, other = real.state(at), damped.state(at)
    rows = len(one.difference)
    assert len(other.difference) == 2 * rows
    # the model is undamped in both: the same modes, and derivatives of them
    np.testing.assert_allclose(damped.sensitivity(other)[:rows], real.sensitivity(one), rtol=1e-12)
    np.testing.assert_array_equal(damped.sensitivity(other)[rows:], 0.0)


def test_a_complex_scale_of_a_shape_drops_out() -> None:
    parameters = parameterise([(1, 2), (12,)], PARTS)
    target = modes_of(change(JOINT, [MemberChange((5,), MemberProperty.MODULUS, factor=1.2)]), 6, BAY_DOFS)
    turned = [replace(m, shape=m.shape * (0.3 - 2j) ** (r - 2)) for r, m in enumerate(target.modes)]
    unscaled = [replace(target, modes=tuple(m), normalisation="none") for m in (target.modes, turned)]
    plain, scaled = (ModalResiduals(Assembly(JOINT), parameters, complex_modes(m), 0.3) for m in unscaled)
    at = parameters.nominal
    # rounding of shapes whose scales lie up to 34 times apart
    np.testing.assert_allclose(scaled.state(at).difference, plain.state(at).difference, atol=1e-9)


@pytest.mark.parametrize("law", [ModalDamping((0.01,)), ViscousDamping(1e-5)])
def test_a_model_whose_damping_is_not_hysteretic_is_refused(law: Damping) -> None:
    with pytest.raises(InvalidInputError, match="hysteretic") as caught:
        fit_of(replace(BAY, damping=law), parameterise([(1, 2)], PARTS))
    assert caught.value.context["field"] == "damping"


def test_real_modes_are_not_asked_for_damping() -> None:
    target = real_modes(modes_of(BAY, 6, BAY_DOFS))
    with pytest.raises(InvalidInputError, match="real modes") as caught:
        ModalResiduals(Assembly(BAY), parameterise([(1, 2)], PARTS), target, 0.3)
    assert caught.value.context["field"] == "parts"
    assert caught.value.context["value"] == "damping"


def test_a_large_structure_is_corrected_without_all_its_modes() -> None:
    groups = [tuple(range(i, i + 13)) for i in range(1, 131, 13)]
    long = long_cantilever()
    assert len(long.dofs) >= EIGENSOLUTION.dense_dofs
    wrong = [
        MemberChange(groups[4], MemberProperty.MODULUS, factor=1.5),
        MemberChange(groups[1], MemberProperty.LOSS_FACTOR, value=0.05),
    ]
    truth = assemble(change(long, wrong))
    exact = modal_basis(truth.mass, truth.stiffness, truth.damping, None, truth.rigid).elastic(8)
    dofs = tuple(Dof(node, "Y") for node in range(5, 132, 5))
    shapes = exact.shapes[[truth.index(dof) for dof in dofs]]
    modes = map(Mode, exact.frequencies, exact.loss_factors, shapes.T)
    parameters = parameterise(groups, ("stiffness", "damping"))
    fit = ModalResiduals(Assembly(long), parameters, complex_modes(ModalModel(tuple(modes), dofs)), 0.3)
    path = iterate(fit, parameters.nominal, StopRule(1e-6, 0.3, 20, 1e6), stage="updating")
    assert path.converged
    expected = parameters.nominal
    expected[[4, 11]] = 1.5, 0.05
    # what modes above eight times the measured range add to the coupling: 1.5e-4 here
    np.testing.assert_allclose(path.final.values, expected, atol=3e-4)

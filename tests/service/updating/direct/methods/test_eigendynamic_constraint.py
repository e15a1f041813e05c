"""The eigendynamic constraint: exact where shapes are, and no further."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError, UnderdeterminedError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import NodeMass, change
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.direct.completion import complete
from modallab.updating.direct.method import DirectOptions
from modallab.updating.direct.methods.eigendynamic_constraint import eigendynamic_constraint
from modallab.updating.direct.run import update_directly
from tests.service.updating.cases import BAY, BAY_DOFS, WRONG_BAY, modes_of
from tests.service.updating.direct.cases import BEAM, BOTH, corrected, measured, problem

METHOD = "eigendynamic_constraint"


def hidden(model: Structure, truth: Structure) -> dict[str, list[float]]:
    pairs = list(zip(model.members, truth.members, strict=True))
    return {
        "mass": [b.mass_factor / a.mass_factor for a, b in pairs],
        "stiffness": [b.bending_factor / a.bending_factor for a, b in pairs],
    }


@pytest.mark.parametrize("count", [1, 5])
@pytest.mark.parametrize("name", ["cantilever", "bay"])
def test_exact_shapes_give_every_coefficient_from_one_mode_on(name: str, count: int) -> None:
    model, truth = (BEAM, BOTH) if name == "cantilever" else (BAY, WRONG_BAY)
    found = corrected(METHOD, problem(truth, count, model))
    for part, expected in hidden(model, truth).items():
        # the true coefficients leave 3e-12 of the cantilever's equations; the smallest singular value is 7e-7
        # with one mode, which may make 4e-6 of it
        np.testing.assert_allclose(list(found.coefficients[part].values()), expected, atol=4e-6)
    for matrix in ("mass", "stiffness"):
        wanted = getattr(assemble(truth), matrix).toarray()
        np.testing.assert_allclose(getattr(found, matrix), wanted, atol=4e-6 * np.abs(wanted).max())


def test_connections_are_kept_and_measured_modes_reproduced() -> None:
    result = update_directly(assemble(BAY), METHOD, measured(WRONG_BAY, 4))
    assert result.converged
    assert result.reproduced is not None
    assert result.reproduced < 1e-8
    # only what rounding makes of sums over other entries lies outside of them, and it is none
    assert result.connectivity_loss == {"mass": 0.0, "stiffness": 0.0}
    assert result.other_modes is not None
    exact = measured(WRONG_BAY, 20).frequencies[4:]
    # modes that were not used are those of the true structure too: the model is it, member by member
    np.testing.assert_allclose(np.sort(result.other_modes.after)[:16], exact, rtol=1e-6)
    assert result.coefficients["stiffness"][12] == pytest.approx(2.0, abs=1e-7)


def test_what_belongs_to_no_member_stays() -> None:
    # undamped: a mass that has none of the damping of the members would make the modes complex
    laden, truth = (
        replace(change(one, [NodeMass(21, 3.0)]), damping=StructuralDamping()) for one in (BEAM, BOTH)
    )
    found = corrected(METHOD, problem(truth, 3, laden))
    for part, expected in hidden(laden, truth).items():
        np.testing.assert_allclose(list(found.coefficients[part].values()), expected, atol=1e-7)


@pytest.mark.parametrize(("noise", "least", "most"), [(1e-6, 0.0, 0.01), (1e-4, 0.2, 2.0)])
def test_errors_of_shapes_are_enlarged_ten_thousandfold(noise: float, least: float, most: float) -> None:
    given, rng = problem(BOTH, 5), np.random.default_rng(0)
    shapes = given.shapes * (1 + noise * rng.standard_normal(given.shapes.shape))
    found = corrected(METHOD, replace(given, shapes=shapes))
    values = np.array(list(found.coefficients["stiffness"].values()))
    assert least <= np.abs(values - hidden(BEAM, BOTH)["stiffness"]).max() < most


def test_a_model_that_misses_the_measured_modes_is_told() -> None:
    noise = ModeNoise(eigenvector=1e-4)
    result = update_directly(assemble(BEAM), METHOD, modes_of(BOTH, 5, BEAM.dofs, noise, seed=0))
    assert result.reproduced is not None
    assert result.reproduced > 0.01  # of a frequency: 0.04 to 0.1 over seeds
    assert not result.converged


def test_coefficients_that_no_structure_has_are_refused() -> None:
    with pytest.raises(UnderdeterminedError, match="no structure has these modes: member 30") as caught:
        update_directly(assemble(BAY), METHOD, modes_of(WRONG_BAY, 10, BAY_DOFS))  # shapes expanded
    assert caught.value.context["field"] == "modes"


def test_a_reduced_model_has_no_members() -> None:
    modes = modes_of(WRONG_BAY, 5, BAY_DOFS)
    given = complete(assemble(BAY), modes, DirectOptions("guyan")).problem(5)
    with pytest.raises(InvalidInputError) as caught:
        eigendynamic_constraint(given)
    assert caught.value.context["field"] == "completion"


def test_modes_that_leave_members_at_rest_are_not_enough() -> None:
    given = problem(BOTH, 2)
    still = given.shapes.copy()
    still[:30] = 0.0  # the first nodes: nothing tells of the members between them
    with pytest.raises(UnderdeterminedError, match="2 modes tell") as caught:
        eigendynamic_constraint(replace(given, shapes=still))
    assert caught.value.context["field"] == "n_modes"


def test_a_large_frame_that_is_right_stays_as_it_is() -> None:
    garteur = STRUCTURES["garteur"]()
    found = corrected(METHOD, problem(garteur, 3, garteur))
    values = np.array([list(table.values()) for table in found.coefficients.values()])
    # nothing is wrong: every coefficient is 1 but for rounding
    np.testing.assert_allclose(values, 1.0, atol=1e-7)

"""A spring to the ground, held against rigid bodies and continuous beams."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.ground_spring import GroundSpring
from modallab.fe.assembly import assemble
from modallab.fe.system import DynamicSystem
from modallab.rig.setup import AcquisitionRun
from tests.rigs import BAR, STEEL, beam_system, dofs, steel_beam

LENGTH, MASS = 1.5, 7800.0 * 5e-4 * 1.5  # m, kg
SHOT = AcquisitionRun(dofs(1), dofs(1))
ENDS = dofs(1, 21)


def on_springs(stiffness: float) -> DynamicSystem:
    system = beam_system()
    for dof in ENDS:
        system = GroundSpring(at=dof, stiffness=stiffness).on_system(system, SHOT)
    return system


def test_a_body_on_two_soft_springs_bounces_and_rocks() -> None:
    stiffness = 1.0  # N/m
    found = on_springs(stiffness).modes().frequencies[:2]
    # of a rigid bar: 2 k / M along, and 2 k (L/2)^2 / (M L^2 / 12) = 6 k / M about
    exact = np.sqrt(np.array([2.0, 6.0]) * stiffness / MASS) / (2 * np.pi)
    # The bar's own bending gives way by k over its stiffness, 1e-4; it costs a share of that.
    np.testing.assert_allclose(found, exact, rtol=1e-4)


def test_springs_that_do_not_give_are_pins() -> None:
    found = on_springs(1e10).modes().frequencies[:4]
    n = np.arange(1, 5)
    rigidity = STEEL.modulus * BAR.second_moment / (STEEL.density * BAR.area)
    exact = (n * np.pi / LENGTH) ** 2 * np.sqrt(rigidity) / (2 * np.pi)
    # Finite elements are stiff by (n pi / 20)^4 / 720, 2e-4 for n = 4; springs give by 1e-5.
    np.testing.assert_allclose(found, exact, rtol=3e-4)


def test_added_to_the_model_it_is_a_spring_of_the_model() -> None:
    model = GroundSpring(at=Dof(5, "Y"), stiffness=2e3).added_to(steel_beam())
    assert [(spring.dof, spring.stiffness) for spring in model.springs] == [(Dof(5, "Y"), 2e3)]
    assert model.effects == ()
    extra = (assemble(model).stiffness - beam_system().stiffness).toarray()
    row = model.index(Dof(5, "Y"))
    assert extra[row, row] == pytest.approx(2e3, rel=1e-6)  # rounding of an entry 1e4 times as large
    assert np.count_nonzero(extra) == 1


def test_it_does_not_sit_at_a_rotation() -> None:
    with pytest.raises(InvalidInputError, match="5:") as caught:
        GroundSpring(at=Dof(5, "RZ")).check(steel_beam())
    assert "rotational_ground_spring" in str(caught.value.context["allowed"])

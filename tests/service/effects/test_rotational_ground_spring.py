"""A rotational spring to the ground, held against the frequency equation of a beam that has one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.rotational_ground_spring import RotationalGroundSpring
from modallab.fe.assembly import assemble
from modallab.fe.structure import Support
from modallab.rig.setup import AcquisitionRun
from tests.rigs import BAR, STEEL, dofs, steel_beam

LENGTH, RIGIDITY = 1.5, STEEL.modulus * BAR.second_moment
SHOT = AcquisitionRun(dofs(5), dofs(5))
PINNED = replace(steel_beam(), supports=(Support(1, ("Y",)), Support(21, ("Y",))))


def wave_number(ratio: float) -> float:
    """beta L of a beam on two pins, one of them with a rotational spring of `ratio` E I / L.

    w = A sin(beta x) + B sinh(beta x) from the free pin; w = 0 and E I w'' = -k w' at the other one give
    cot(beta L) - coth(beta L) = 2 beta L / ratio.
    """

    def left(x: float) -> float:
        return float(1 / np.tan(x) - 1 / np.tanh(x) - 2 * x / ratio)

    return float(brentq(left, np.pi + 1e-9, 3.9266023))


@pytest.mark.parametrize("ratio", [0.01, 1.0, 10.0, 1e3, 1e6])
def test_a_pin_that_holds_the_rotation_leads_from_pinned_to_clamped(ratio: float) -> None:
    effect = RotationalGroundSpring(at=Dof(21, "RZ"), stiffness=ratio * RIGIDITY / LENGTH)
    found = effect.on_system(assemble(PINNED), SHOT).modes().frequencies[0]
    speed = np.sqrt(RIGIDITY / (STEEL.density * BAR.area))
    exact = (wave_number(ratio) / LENGTH) ** 2 * speed / (2 * np.pi)
    assert found == pytest.approx(exact, rel=1e-5)  # finite elements: (pi / 20)^4 / 720, 1e-6


def test_added_to_the_model_it_is_a_spring_of_the_model() -> None:
    model = RotationalGroundSpring(at=Dof(5, "RZ"), stiffness=30.0).added_to(steel_beam())
    assert [(spring.dof, spring.stiffness) for spring in model.springs] == [(Dof(5, "RZ"), 30.0)]
    assert model.effects == ()


def test_it_does_not_sit_at_a_translation() -> None:
    with pytest.raises(InvalidInputError, match="5:") as caught:
        RotationalGroundSpring(at=Dof(5, "Y")).check(steel_beam())
    assert "ground_spring" in str(caught.value.context["allowed"])

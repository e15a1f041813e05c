"""Supports that yield: the exact transfer matrix, Rayleigh's first-order drop, and a diagnosis of one."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.effects.elastic_support import ElasticSupport
from modallab.effects.rotational_elastic_support import RotationalElasticSupport
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import PointMass, Support
from modallab.rig.setup import AcquisitionRun
from tests.cantilevers import CANTILEVER, HELD_OUT, draw_cantilever
from tests.rigs import BAR, STEEL, dofs, rig, steel_beam

N, LENGTH = 30, 1.2
BEND = STEEL.modulus * BAR.second_moment
MASS = STEEL.density * BAR.area * LENGTH
ENDS = (Support(1, ("Y",)), Support(N + 1, ("Y",)))
SHOT = AcquisitionRun(dofs(5), dofs(5))


def yielding(flexibility: float, masses: tuple[PointMass, ...] = ()) -> FloatArray:
    """Hz, three frequencies of a pinned beam whose left support yields."""
    pinned = beam(length=LENGTH, n_elements=N, section=BAR, material=STEEL, supports=ENDS, masses=masses)
    loose = ElasticSupport(Dof(1, "Y"), flexibility).on_system(assemble(pinned), SHOT)
    return loose.modes().frequencies[:3]


def exactly(flexibility: float, mass: float = 0.0) -> FloatArray:
    """Hz, the same by the transfer matrix of (w, w', M, V) of a beam without elements.

    The support carries the shear V less the inertia of a mass, kg, on it.
    """

    def unbalanced(frequency: float) -> float:
        omega2 = (2 * np.pi * frequency) ** 2
        square = STEEL.density * BAR.area * omega2
        along = np.array([[0, 1, 0, 0], [0, 0, 1 / BEND, 0], [0, 0, 0, 1], [square, 0, 0, 0]])
        # (1 / flexibility - omega^2 mass) w = -V, at the left end of the beam
        left = np.array([[flexibility, 0], [0, 1], [0, 0], [-(1 - omega2 * mass * flexibility), 0]])
        return float(np.linalg.det((expm(along * LENGTH) @ left)[[0, 2]]))

    grid = np.linspace(0.5, 300.0, 3000)
    values = [unbalanced(f) for f in grid]
    steps = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0][:3]
    return np.array([brentq(unbalanced, grid[i], grid[i + 1], xtol=1e-10) for i in steps])


@pytest.mark.parametrize("ratio", [1e-4, 1e-2, 0.3, 10.0])  # flexibility E I / L^3
@pytest.mark.parametrize("mass", [0.0, 0.4])
def test_a_beam_on_a_yielding_support_has_the_frequencies_of_the_exact_transfer_matrix(
    ratio: float, mass: float
) -> None:
    flexibility = ratio * LENGTH**3 / BEND
    found = yielding(flexibility, (PointMass(1, mass),))
    # cubic elements: (beta h)^4 / 1440 = 7e-6 of the third mode
    np.testing.assert_allclose(found, exactly(flexibility, mass), rtol=1e-5)


def test_a_little_flexibility_lowers_frequencies_by_the_square_of_the_reaction() -> None:
    """Sine modes of unit mass: reaction E I k^3 sqrt(2 / m), so d omega^2 / omega^2 = -2 E I k^2 c / L."""
    flexibility = 1e-7 * LENGTH**3 / BEND
    pinned = beam(length=LENGTH, n_elements=N, section=BAR, material=STEEL, supports=ENDS)
    bare = assemble(pinned).modes().frequencies[:3]
    found = (yielding(flexibility) / bare) ** 2 - 1
    k = np.arange(1, 4) * np.pi / LENGTH
    # the reaction of cubic elements errs by (k h)^2 / 12 = 8e-3 at the third mode, rounding by 1e-8 / 2e-6
    np.testing.assert_allclose(found, -2 * BEND / LENGTH * k**2 * flexibility, rtol=2e-2)


@pytest.mark.parametrize("at", [Dof(1, "RZ"), Dof(2, "Y"), Dof(1, "X")])
def test_it_needs_a_translation_that_is_held(at: Dof) -> None:
    with pytest.raises(InvalidInputError) as caught:
        ElasticSupport(at).check(CANTILEVER)
    assert caught.value.context["allowed"] == ["1:+Y"]


def test_a_free_structure_has_no_place_for_it() -> None:
    assert not ElasticSupport.places(assemble(steel_beam()), rig(1))


def test_what_no_member_carries_is_no_place() -> None:
    lateral = beam(
        length=1.0,
        n_elements=2,
        section=BAR,
        material=STEEL,
        supports=(Support(1, ("Y", "RZ")), Support(2, ("Y",))),
    )
    both_held = assemble(lateral)
    assert ElasticSupport.places(both_held, rig(1)) == (Dof(1, "Y"), Dof(2, "Y"))
    clamped = beam(
        length=1.0,
        n_elements=2,
        section=BAR,
        material=STEEL,
        supports=(Support(1, ("Y", "RZ")), Support(2, ("Y", "RZ"))),
    )
    # between two clamps nothing moves
    assert ElasticSupport.places(assemble(clamped), rig(1)) == (Dof(2, "Y"),)


def test_among_all_suspects_a_yielding_support_is_found() -> None:
    hidden = ElasticSupport(Dof(1, "Y"), 1e-6)
    found = diagnose(CANTILEVER, draw_cantilever([hidden]), hold_out=HELD_OUT)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, hidden.at)
    number = step.effect.parameters["flexibility"]
    # four standard errors, one time in 16,000 beyond
    assert abs(number.value - hidden.flexibility) < 4 * number.standard_error


def test_a_clamp_that_yields_and_turns_is_found_as_both() -> None:
    hidden = [ElasticSupport(Dof(1, "Y"), 1e-6), RotationalElasticSupport(Dof(1, "RZ"), 1e-4)]
    kinds = ["elastic_support", "rotational_elastic_support", "stiffness_error", "joint_flexibility"]
    found = diagnose(CANTILEVER, draw_cantilever(hidden), suspects=kinds, hold_out=HELD_OUT)
    assert found.verdict is Verdict.EXPLAINED
    named = {step.effect.kind: step.effect.parameters["flexibility"] for step in found.steps}
    assert named.keys() == {"elastic_support", "rotational_elastic_support"}
    for effect in hidden:
        number = named[effect.kind]
        assert abs(number.value - effect.parameters["flexibility"]) < 4 * number.standard_error

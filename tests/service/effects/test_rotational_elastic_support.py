"""Clamps that turn: the exact transfer matrix, Rayleigh's first-order drop, and a diagnosis of one."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.effects.rotational_elastic_support import RotationalElasticSupport
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import Support
from modallab.rig.setup import AcquisitionRun
from tests.cantilevers import CANTILEVER, HELD_OUT, draw_cantilever
from tests.rigs import BAR, STEEL, dofs, steel_beam

N, LENGTH = 30, 1.2
BEND = STEEL.modulus * BAR.second_moment
SYSTEM = assemble(
    beam(length=LENGTH, n_elements=N, section=BAR, material=STEEL, supports=(Support(1, ("Y", "RZ")),))
)
ROOT = Dof(1, "RZ")


def turning(flexibility: float) -> FloatArray:
    run = AcquisitionRun(dofs(5), dofs(5))
    return RotationalElasticSupport(ROOT, flexibility).on_system(SYSTEM, run).modes().frequencies[:3]


def exactly(flexibility: float) -> FloatArray:
    """Hz, three frequencies of a cantilever whose root turns by flexibility times moment.

    By the transfer matrix of (w, w', M, V) of a beam without elements.
    """

    def unbalanced(frequency: float) -> float:
        square = STEEL.density * BAR.area * (2 * np.pi * frequency) ** 2
        along = np.array([[0, 1, 0, 0], [0, 0, 1 / BEND, 0], [0, 0, 0, 1], [square, 0, 0, 0]])
        root = np.array([[0, 0], [flexibility, 0], [1, 0], [0, 1]])  # by moment and shear
        return float(np.linalg.det((expm(along * LENGTH) @ root)[2:]))

    grid = np.linspace(0.01, 200.0, 2000)
    values = [unbalanced(f) for f in grid]
    steps = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0][:3]
    return np.array([brentq(unbalanced, grid[i], grid[i + 1], xtol=1e-10) for i in steps])


@pytest.mark.parametrize("ratio", [1e-3, 0.1, 1.0, 30.0])  # flexibility E I / L
def test_a_beam_on_a_turning_root_has_the_frequencies_of_the_exact_transfer_matrix(ratio: float) -> None:
    flexibility = ratio * LENGTH / BEND
    # cubic elements: (beta h)^4 / 1440 = 5e-6 of the third mode
    np.testing.assert_allclose(turning(flexibility), exactly(flexibility), rtol=1e-5)


def test_a_little_flexibility_lowers_frequencies_by_the_square_of_the_moment() -> None:
    """d omega^2 = -flexibility M^2, and M = 2 omega sqrt(E I / L) of every cantilever's mode of unit mass."""
    flexibility = 1e-5 * LENGTH / BEND
    bare = SYSTEM.modes().frequencies[:3]
    found = (turning(flexibility) / bare) ** 2 - 1
    # the second order is that of 1e-5 times the sum over modes; the curvature at the root of a cubic element
    # errs by (beta h)^2 / 12 = 6e-3 at the third mode
    np.testing.assert_allclose(found, -4 * BEND / LENGTH * flexibility, rtol=1e-2)


def test_a_clamp_that_turns_freely_is_a_pin() -> None:
    pinned = assemble(
        beam(length=LENGTH, n_elements=N, section=BAR, material=STEEL, supports=(Support(1, ("Y",)),))
    )
    # the rigid-body rotation is at no frequency, or almost: sqrt(3 / (flexibility m L^2)) / 2 pi = 5e-4 Hz
    np.testing.assert_allclose(turning(1e5)[1:], pinned.modes().elastic(2).frequencies, rtol=1e-6)


@pytest.mark.parametrize("at", [Dof(1, "Y"), Dof(2, "RZ"), Dof(99, "RZ")])
def test_it_needs_a_rotation_that_is_held(at: Dof) -> None:
    with pytest.raises(InvalidInputError) as caught:
        RotationalElasticSupport(at).check(CANTILEVER)
    assert caught.value.context["allowed"] == ["1:+RZ"]


def test_a_free_structure_has_no_place_for_it() -> None:
    assert not RotationalElasticSupport.places(assemble(steel_beam()), draw_cantilever([]).setup)


@pytest.mark.parametrize("flexibility", [1e-6, 1e-4])
def test_among_all_suspects_a_turning_clamp_is_found(flexibility: float) -> None:
    hidden = RotationalElasticSupport(ROOT, flexibility)
    found = diagnose(CANTILEVER, draw_cantilever([hidden]), hold_out=HELD_OUT)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, ROOT)
    number = step.effect.parameters["flexibility"]
    # four standard errors, one time in 16,000 beyond
    assert abs(number.value - flexibility) < 4 * number.standard_error


def test_a_clamp_as_modelled_is_not_blamed() -> None:
    kinds = ["rotational_elastic_support", "elastic_support"]
    found = diagnose(CANTILEVER, draw_cantilever([], seed=3), suspects=kinds, hold_out=HELD_OUT)
    assert found.verdict is Verdict.NOTHING_MISSING

import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab.core.dof import Dof
from modallab.core.errors import UnderdeterminedError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.system import DynamicSystem
from tests.rigs import BAR, STEEL, dofs, steel_beam

BEAM, CANTILEVER, BAY = (assemble(STRUCTURES[n]()) for n in ("chapter-5-beam", "cantilever", "bay"))
MASTERS = dofs(*range(1, 22, 2))


def test_the_modes_that_are_kept_are_exact_and_no_others_are_there() -> None:
    reduced = reduce(BEAM, MASTERS, reduction_of("serep", {"modes": 6}))
    found, shapes = reduced.modes()
    full = BEAM.modes()
    assert len(found) == 2 + 6  # rigid-body modes with them, at 11 masters
    np.testing.assert_allclose(found[2:], full.frequencies[2:8], rtol=1e-7)  # rounding
    exact = full.shapes[:, 2:8].real
    whole = reduced.transformation @ shapes[:, 2:]
    signs = np.sign((whole * exact).sum(axis=0))
    np.testing.assert_allclose(whole * signs, exact, atol=1e-6 * np.abs(exact).max())


def test_shapes_of_the_reduced_model_are_the_models_own_at_the_masters() -> None:
    _, shapes = reduce(BEAM, MASTERS, reduction_of("serep", {"modes": 4})).modes()
    exact = BEAM.modes().shapes[[BEAM.index(dof) for dof in MASTERS], 2:6].real
    signs = np.sign((shapes[:, 2:] * exact).sum(axis=0))
    # rounding; what the masters could do besides has no mass there, and no place in a shape
    np.testing.assert_allclose(shapes[:, 2:] * signs, exact, atol=1e-6 * np.abs(exact).max())


def test_motion_that_no_kept_mode_has_is_fitted() -> None:
    reduced = reduce(BEAM, MASTERS, reduction_of("serep", {"modes": 3}))
    at_masters = reduced.transformation[[BEAM.index(dof) for dof in MASTERS]]
    np.testing.assert_allclose(at_masters @ at_masters, at_masters, atol=1e-10)  # a projection
    assert np.linalg.matrix_rank(at_masters, tol=1e-6) == 5


def test_left_to_itself_it_keeps_what_masters_tell_apart() -> None:
    found, _ = reduce(BEAM, MASTERS, reduction_of("serep")).modes()
    np.testing.assert_allclose(found[2:], BEAM.modes().frequencies[2 : len(found)], rtol=1e-6)
    assert 8 <= len(found) <= 11
    few, _ = reduce(BEAM, dofs(1, 11, 21), reduction_of("serep")).modes()
    assert len(few) == 3  # two rigid-body modes and the first bending mode


def test_left_to_itself_it_keeps_to_the_band() -> None:
    full = BEAM.modes().frequencies
    within = reduction_of("serep").reaching(full[4])  # 127.8 Hz, the third bending mode
    found, _ = reduce(BEAM, MASTERS, within).modes()
    np.testing.assert_allclose(found[2:], full[2:5], rtol=1e-7)  # rounding; the next one is at 211 Hz
    asked = reduction_of("serep", {"modes": 5})
    assert asked.reaching(full[4]) == asked
    low, _ = reduce(BEAM, MASTERS, reduction_of("serep").reaching(1.0)).modes()
    assert len(low) == 3  # never without an elastic mode


def test_motions_that_no_master_sees_stay_out() -> None:
    # watched across, the bay's motion along X is neither there nor in the way
    across = tuple(dof for dof in BAY.dofs if dof.direction == "Y")
    found, _ = reduce(BAY, across, reduction_of("serep", {"modes": 5})).modes()
    assert len(found) == 2 + 5
    np.testing.assert_allclose(found[2:], BAY.modes().frequencies[3:8], rtol=1e-6)


def test_too_few_masters_are_refused_with_the_count() -> None:
    with pytest.raises(
        UnderdeterminedError, match="11 masters cannot follow 12 modes, 2 of them rigid"
    ) as caught:
        reduce(BEAM, MASTERS, reduction_of("serep", {"modes": 10}))
    assert caught.value.context == {"field": "modes", "value": 10, "allowed": {"maximum": 9}}
    with pytest.raises(UnderdeterminedError, match="2 masters do not tell the first mode"):
        reduce(BEAM, dofs(1, 21), reduction_of("serep"))


def test_masters_at_which_modes_look_alike_are_refused() -> None:
    # four masses on springs of their own, of which the second is not watched
    points = tuple(Dof(node, "X") for node in range(1, 5))
    springs = csc_array(np.diag([1.0, 2.0, 3.0, 4.0]))
    apart = DynamicSystem(mass=csc_array(np.eye(4)), stiffness=springs, dofs=points)
    watched = (points[0], *points[2:])
    with pytest.raises(UnderdeterminedError, match="do not tell the first 3 modes"):
        reduce(apart, watched, reduction_of("serep", {"modes": 3}))
    found, _ = reduce(apart, watched, reduction_of("serep")).modes()
    np.testing.assert_allclose(2 * np.pi * found, [1.0])  # those before the one that they do not see


def test_a_large_structure_is_solved_for_its_lowest_modes_only() -> None:
    large = assemble(steel_beam(n_elements=EIGENSOLUTION.dense_dofs))
    reduced = reduce(
        large, dofs(*range(1, EIGENSOLUTION.dense_dofs + 2, 25)), reduction_of("serep", {"modes": 6})
    )
    found, _ = reduced.modes()
    # Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-1: beta L of the free beam
    roots = np.array([4.73004074, 7.85320462, 10.9956079, 14.1371655, 17.2787597, 20.4203522])
    speed = np.sqrt(STEEL.modulus * BAR.second_moment / (STEEL.density * BAR.area))
    exact = roots**2 / (2 * np.pi * 1.5**2) * speed
    np.testing.assert_allclose(found[2:], exact, rtol=1e-5)  # rounding: (n elements)^4 of condition

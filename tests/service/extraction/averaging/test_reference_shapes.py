import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.extraction.averaging.reference_shapes import ReferenceShapes, reference_shapes
from modallab.extraction.averaging.scaling import scaled_shapes

DOFS = tuple(Dof(node, "Y") for node in range(1, 6))
PHI = np.array([[1.0, 0.6, -0.3, -0.8, 0.9], [0.0, 0.9, 0.4, -0.7, 1.2]])  # the second stands still at 1
ERROR = 1e-3


def constants(drives: tuple[Dof, ...], noise: float = 0.0, seed: int = 0) -> ComplexArray:
    """(2, 5 n_ref) 1/kg, DoF by DoF."""
    reach = np.array([[d.sign * phi[DOFS.index(Dof(d.node, "Y"))] for d in drives] for phi in PHI])
    values = (PHI[:, :, None] * reach[:, None]).reshape(2, -1)
    rng = np.random.default_rng(seed)
    error = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    return np.asarray(values + noise * error, complex)


def shapes(drives: tuple[Dof, ...], noise: float = 0.0, seed: int = 0) -> ReferenceShapes:
    found = constants(drives, noise, seed)
    return reference_shapes(found, np.full(found.shape, ERROR), DOFS, drives)


def test_products_give_the_shapes_they_are_of() -> None:
    found = shapes((DOFS[1], DOFS[4]))
    np.testing.assert_allclose(found.shape, PHI, atol=1e-12)  # rounding through 20 rounds
    assert found.scale is not None
    assert found.inconsistency.max() < 1e-12


def test_a_drive_point_at_a_node_does_no_harm_beside_another() -> None:
    found = shapes((DOFS[0], DOFS[3]), noise=ERROR)
    # the second mode rests on 4:+Y alone: errors of 1e-3 over its 0.7
    sign = np.sign((found.shape.real * PHI).sum(axis=1))[:, None]
    assert np.abs(sign * found.shape - PHI).max() < 5 * ERROR / 0.7
    assert not any("hardly shows" in flag for flag in found.flags(1))


def test_a_reference_that_points_the_other_way_changes_nothing() -> None:
    np.testing.assert_allclose(
        shapes((DOFS[1], Dof(5, "Y", -1))).shape, shapes((DOFS[1], DOFS[4])).shape, atol=1e-12
    )


def test_errors_are_the_scatter_of_repeated_tests() -> None:
    drives = (DOFS[1], DOFS[4])
    every = np.array([shapes(drives, ERROR, seed).shape for seed in range(400)])
    scatter = every.real.std(axis=0)  # that of the size, as shapes are real
    stated = shapes(drives, ERROR, 0).error
    # 400 draws tell a scatter to 4 %; at drive points shape and scale share an error, so that it is less
    assert (stated > 0.85 * scatter).all()
    away = [0, 2, 3]
    np.testing.assert_allclose(stated[:, away], scatter[:, away], rtol=0.2)


def test_one_reference_is_scaled_by_its_own_drive_point() -> None:
    found = constants(DOFS[1:2], ERROR)
    error: FloatArray = np.full(found.shape, ERROR)
    own = reference_shapes(found, error, DOFS, DOFS[1:2])
    np.testing.assert_array_equal(own.shape, scaled_shapes(found, error, 1, 1)[0])
    assert own.choice_text() == {}


def test_constants_of_no_one_shape_are_flagged_with_how_far() -> None:
    drives = (DOFS[1], DOFS[4])
    found = constants(drives).reshape(2, 5, 2)
    found[0, 2, 1] *= -1  # a polarity that changed between two tests
    told = reference_shapes(found.reshape(2, -1), np.full((2, 10), ERROR), DOFS, drives)
    assert any(flag.startswith("references differ: ") for flag in told.flags(0))
    assert list(told.flags(1)) == []
    assert told.choice_text()["references"].startswith("2:+Y, 5:+Y: ")


def test_drive_points_that_differ_about_the_scale_are_flagged() -> None:
    drives = (DOFS[1], DOFS[4])
    gains = np.array([1.0, 1.3])  # of the second force gauge
    found = (constants(drives).reshape(2, 5, 2) * gains).reshape(2, -1)
    told = reference_shapes(found, np.full(found.shape, ERROR), DOFS, drives)
    assert told.inconsistency.max() < 1e-12, "each column is the same shape all the same"
    (flag,) = told.flags(0)
    assert flag.startswith("drive points differ by ")
    assert told.scale is not None
    assert told.scale.inconsistency[0] == pytest.approx(
        0.13, abs=0.03
    )  # half of the gain's error to either side

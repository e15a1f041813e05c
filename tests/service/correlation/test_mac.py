import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.correlation.mac import comac, compare, mac, pair_modes

POINTS = tuple(Dof(node, "Y") for node in range(1, 9))


def shapes(seed: int, n_modes: int = 4) -> ComplexArray:
    rng = np.random.default_rng(seed)
    values: ComplexArray = rng.standard_normal((8, n_modes)) + 0.1j * rng.standard_normal((8, n_modes))
    return values


def model(values: ComplexArray, dofs: tuple[Dof, ...] = POINTS, start: float = 10.0) -> ModalModel:
    modes = tuple(Mode(start * (i + 1), 0.01, column) for i, column in enumerate(values.T))
    return ModalModel(modes, dofs)


@given(seed=st.integers(0, 1000), scale=st.complex_numbers(min_magnitude=1e-6, max_magnitude=1e6))
@settings(max_examples=50, deadline=None)
def test_mac_does_not_see_a_complex_scale_and_never_leaves_0_to_1(seed: int, scale: complex) -> None:
    one, other = shapes(seed), shapes(seed + 1)
    values = mac(one, other)
    assert (values >= 0).all()
    assert (values <= 1).all()
    np.testing.assert_allclose(mac(scale * one, other), values, rtol=1e-9, atol=1e-12)  # rounding
    np.testing.assert_allclose(np.diag(mac(one, scale * one)), 1.0, rtol=1e-12)


def test_mac_takes_the_conjugate_of_complex_shapes() -> None:
    circling = np.array([[1.0], [1j]])
    assert mac(circling, circling)[0, 0] == pytest.approx(1.0)
    assert mac(circling, circling.conj())[0, 0] == pytest.approx(0.0)


def test_a_shape_of_zeros_is_like_nothing() -> None:
    assert mac(np.zeros((3, 1)), np.ones((3, 2))).tolist() == [[0.0, 0.0]]


def test_modes_that_changed_places_find_each_other() -> None:
    values = shapes(3)
    found = compare(model(values), model(values[:, [1, 0, 3, 2]]))
    assert found.pairs == ((0, 1), (1, 0), (2, 3), (3, 2))
    np.testing.assert_allclose(found.frequency_differences, [-10.0, 10.0, -10.0, 10.0])
    np.testing.assert_allclose(found.comac, 1.0, rtol=1e-12)  # the same shapes, whatever their order


def test_two_measured_modes_never_share_a_model_mode() -> None:
    # both prefer column 0; greedy by rows would leave row 1 with 0.1
    assert pair_modes(np.array([[0.9, 0.85], [0.95, 0.1]])) == ((0, 1), (1, 0))


def test_below_the_floor_nothing_pairs() -> None:
    assert pair_modes(np.array([[0.9, 0.0], [0.0, 0.2]])) == ((0, 0),)
    assert pair_modes(np.array([[0.9, 0.0], [0.0, 0.2]]), floor=0.1) == ((0, 0), (1, 1))
    assert pair_modes(np.zeros((2, 3)), floor=0.0) == ()


def test_more_measured_modes_than_the_model_has_leave_some_alone() -> None:
    values = shapes(5)
    found = compare(model(values[:, :2]), model(values))
    assert found.mac.shape == (4, 2)
    assert found.pairs == ((0, 0), (1, 1))


def test_only_common_dofs_count_and_a_turned_sensor_is_turned_back() -> None:
    values = shapes(7)
    measured = tuple(Dof(node, "Y", -1 if node % 2 else 1) for node in (7, 3, 2, 20, 5, 8))
    rows = np.array([6, 2, 1, 0, 4, 7])
    sign = np.array([dof.sign for dof in measured])
    seen = values[rows] * sign[:, None]
    seen[3] = 99  # at node 20, of which the model knows nothing
    found = compare(model(values), model(seen, measured))
    assert [str(dof) for dof in found.dofs] == ["2:+Y", "3:+Y", "5:+Y", "7:+Y", "8:+Y"]
    np.testing.assert_allclose(np.diag(found.mac), 1.0, rtol=1e-12)


def test_comac_points_at_the_dof_that_differs() -> None:
    values = shapes(9)
    wrong = values.copy()
    wrong[2] = shapes(10)[2]
    found = comac(wrong, 3j * values)
    assert np.argmin(found) == 2
    assert comac(np.zeros((2, 1), complex), np.array([[0j], [1]])).tolist() == [1.0, 0.0]


def test_what_cannot_be_compared_is_named() -> None:
    values = shapes(1)
    elsewhere = tuple(Dof(node, "Z") for node in range(1, 9))
    with pytest.raises(InvalidInputError, match="no degree of freedom"):
        compare(model(values), model(values, elsewhere))
    with pytest.raises(InvalidInputError, match="no modes"):
        compare(model(values), ModalModel((), POINTS))

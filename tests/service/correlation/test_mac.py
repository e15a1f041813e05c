import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.correlation.mac import mac, pair_modes, pole_weighted_mac
from tests.service.correlation.cases import shapes


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


def test_two_measured_modes_never_share_a_model_mode() -> None:
    # both prefer column 0; greedy by rows would leave row 1 with 0.1
    assert pair_modes(np.array([[0.9, 0.85], [0.95, 0.1]])) == ((0, 1), (1, 0))


def test_below_the_floor_nothing_pairs() -> None:
    assert pair_modes(np.array([[0.9, 0.0], [0.0, 0.2]])) == ((0, 0),)
    assert pair_modes(np.array([[0.9, 0.0], [0.0, 0.2]]), floor=0.1) == ((0, 0), (1, 1))
    assert pair_modes(np.zeros((2, 3)), floor=0.0) == ()


def eigenvalues(*frequencies: float, loss_factor: float = 0.01) -> np.ndarray:
    return np.asarray((2 * np.pi * np.array(frequencies)) ** 2 * (1 + 1j * loss_factor))


def test_pole_weighting_is_the_mac_of_the_long_vectors() -> None:
    one, other = shapes(1, 3), shapes(2, 2)
    poles = [1j * np.sqrt(eigenvalues(10.0, 25.0, 40.0)), 1j * np.sqrt(eigenvalues(12.0, 80.0))]
    step = 1 / np.abs(poles[1][1]) * np.pi  # half a circle of the highest
    powers = np.arange(6)
    # written out: [phi; z phi; ...; z^5 phi] of every mode
    long = [
        np.vstack([shape * np.exp(k * pole * step) for k in powers])
        for shape, pole in zip((one, other), poles, strict=True)
    ]
    found = pole_weighted_mac(one, other, eigenvalues(10.0, 25.0, 40.0), eigenvalues(12.0, 80.0), order=5)
    np.testing.assert_allclose(found, mac(*long), rtol=1e-9)  # rounding


def test_modes_alike_in_shape_alone_are_told_apart_by_their_poles() -> None:
    shape = shapes(3, 1)
    both = np.hstack([shape, 2j * shape])
    values = eigenvalues(30.0, 60.0)
    np.testing.assert_allclose(mac(both, both), 1.0, rtol=1e-12)
    found = pole_weighted_mac(both, both, values, values)
    np.testing.assert_allclose(np.diag(found), 1.0, rtol=1e-12)
    assert found[0, 1] < 0.1


def test_of_order_0_it_is_the_plain_mac_and_never_more() -> None:
    one, other = shapes(4), shapes(5)
    poles = eigenvalues(10, 20, 30, 40), eigenvalues(11, 19, 35, 41)
    np.testing.assert_allclose(pole_weighted_mac(one, other, *poles, order=0), mac(one, other), rtol=1e-12)
    assert (pole_weighted_mac(one, other, *poles) <= mac(one, other) + 1e-12).all()

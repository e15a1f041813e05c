import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.arrays import ComplexArray
from modallab.correlation.complexity import mean_phase, mean_phase_deviation, phase_collinearity

REAL = np.array([[1.0, 0.3], [-2.0, 0.5], [0.5, -1.0]])


def drawn(seed: int) -> ComplexArray:
    rng = np.random.default_rng(seed)
    return np.asarray(rng.standard_normal((9, 4)) + 1j * rng.standard_normal((9, 4)))


@given(st.floats(-np.pi, np.pi), st.floats(1e-100, 1e100))
def test_a_real_shape_is_a_line_whatever_its_factor(turn: float, size: float) -> None:
    shapes = size * np.exp(1j * turn) * REAL
    np.testing.assert_allclose(phase_collinearity(shapes), 1.0, rtol=1e-12)  # rounding
    np.testing.assert_allclose(mean_phase_deviation(shapes), 0.0, atol=1e-7)  # rounding's root
    # a line has no sense: phases are alike modulo half a turn
    np.testing.assert_allclose(np.exp(2j * (mean_phase(shapes) - turn)), 1.0, atol=1e-12)


def test_a_travelling_wave_has_no_line() -> None:
    wave = np.exp(2j * np.pi * np.arange(12) / 12)[:, None]
    assert phase_collinearity(wave)[0] == pytest.approx(0.0, abs=1e-12)
    # phases spread evenly: a quarter of half a turn off any line, to the 12 points' 15 degrees
    assert mean_phase_deviation(wave)[0] == pytest.approx(np.pi / 4, abs=np.pi / 12)


@pytest.mark.parametrize("seed", range(5))
def test_collinearity_is_that_of_real_and_imaginary_parts(seed: int) -> None:
    shapes = drawn(seed)
    xx, yy = (shapes.real**2).sum(axis=0), (shapes.imag**2).sum(axis=0)
    xy = (shapes.real * shapes.imag).sum(axis=0)
    np.testing.assert_allclose(
        phase_collinearity(shapes), ((xx - yy) ** 2 + 4 * xy**2) / (xx + yy) ** 2, rtol=1e-10
    )


@pytest.mark.parametrize("seed", range(5))
def test_the_mean_phase_is_the_principal_axis_of_the_components(seed: int) -> None:
    shapes = drawn(seed)
    for r, angle in enumerate(mean_phase(shapes)):
        points = np.stack([shapes[:, r].real, shapes[:, r].imag], axis=1)
        axis = np.linalg.svd(points)[2][0]
        assert abs(axis @ [np.cos(angle), np.sin(angle)]) == pytest.approx(1.0, abs=1e-10)  # rounding


def test_a_small_turn_of_one_component_is_its_share_of_the_deviation() -> None:
    shape = np.array([1.0, -1.0, 1.0, np.exp(0.02j)])[:, None]
    # the line turns by a quarter of it: three components then are off by 0.005, one by 0.015
    assert mean_phase_deviation(shape)[0] == pytest.approx((3 * 0.005 + 0.015) / 4, rel=1e-3)  # second order


def test_a_shape_of_zeros_is_no_line_and_not_nan() -> None:
    still = np.zeros((3, 1), complex)
    assert phase_collinearity(still)[0] == mean_phase(still)[0] == mean_phase_deviation(still)[0] == 0.0

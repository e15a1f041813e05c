import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.effects.rattle import Rattle
from modallab.rig.local_force import LocalForce

HERE = Dof(7, "Y")


def force(effect: CubicStiffness | Friction | Rattle) -> LocalForce:
    found = effect.on_motion()
    assert found is not None
    return found


def test_a_cubic_spring_is_three_times_its_mean_square_to_a_gaussian_motion() -> None:
    found = force(CubicStiffness(HERE, 2e9)).linearised(3e-4)
    assert np.isclose(found.slope, 3 * 2e9 * 3e-4**2, rtol=1e-10)  # a polynomial: exact to rounding


def test_what_a_cubic_leaves_is_six_times_the_cube_of_the_correlation() -> None:
    found = force(CubicStiffness(HERE, 2e9)).linearised(3e-4)
    rho = np.linspace(-1, 1, 9)
    wanted = 6 * 2e9**2 * 3e-4**6 * rho**3
    np.testing.assert_allclose(found.residual_correlation(rho), wanted, rtol=1e-9, atol=1e-9 * wanted.max())


def test_dry_friction_is_a_damper_that_weakens_with_the_motion() -> None:
    for rms in (0.1, 1.0):
        found = force(Friction(HERE, 0.5, 1e-6)).linearised(rms)
        # the step takes 1e-5 of the motion at most, the quadrature a fiftieth of its own step
        assert np.isclose(found.slope, 0.5 * np.sqrt(2 / np.pi) / rms, rtol=1e-4)


def test_what_friction_leaves_follows_the_arcsine_law() -> None:
    found = force(Friction(HERE, 0.5, 1e-9)).linearised(1.0)
    rho = np.array([-0.9, -0.5, 0.2, 0.7])
    wanted = 0.25 * 2 / np.pi * (np.arcsin(rho) - rho)  # Van Vleck and Middleton (1966), less its line
    # 200 orders: what is left out falls as rho^200
    np.testing.assert_allclose(found.residual_correlation(rho), wanted, rtol=5e-3)


def test_stops_within_the_gap_do_nothing_and_far_beyond_it_all() -> None:
    stop = force(Rattle(HERE, 1e4, 1e-4))
    assert stop.linearised(1e-5).slope < 1e-9 * 1e4
    assert np.isclose(stop.linearised(1e-1).slope, 1e4, rtol=1e-3)  # erfc(7e-4)


@pytest.mark.parametrize("rho", [-0.6, 0.3, 0.8])
def test_any_law_leaves_what_the_two_point_normal_law_says(rho: float) -> None:
    one = force(Rattle(HERE, 1e4, 1e-4)).linearised(1.5e-4)

    z = np.linspace(-7, 7, 1401)
    x, y = np.meshgrid(z, z)
    quadratic = (x**2 - 2 * rho * x * y + y**2) / (2 * (1 - rho**2))
    density = np.exp(-quadratic) / (2 * np.pi * np.sqrt(1 - rho**2)) * (z[1] - z[0]) ** 2
    left = one.residual(1.5e-4 * z)
    wanted = left @ density @ left
    # the kinks of the law cost both quadratures 1e-4 of the variance: (step)^2
    assert abs(float(one.residual_correlation(np.array(rho))) - wanted) < 1e-4 * (1e4 * 1.5e-4) ** 2


@pytest.mark.parametrize(
    "effect", [CubicStiffness(HERE, 2e9), Friction(HERE, 0.5, 1e-5), Rattle(HERE, 1e4, 1e-4)], ids=type
)
def test_what_a_residual_remembers_is_the_slope_of_its_correlation(
    effect: CubicStiffness | Friction | Rattle,
) -> None:
    one = force(effect).linearised(1.5e-4)
    rho, step = np.array([-0.9, -0.3, 0.0, 0.2, 0.7]), 1e-3
    over, under = (one.residual_correlation(rho + sign * step) for sign in (1, -1))
    wanted = (over - under) / (2 * step) / 1.5e-4**2
    # differences are straight to (step)^2 times a third derivative of some hundred, the sum to 1e-7 / step
    tolerance = 1e-3 * np.abs(wanted).max()
    np.testing.assert_allclose(one.residual_correlation_derivative(rho), wanted, atol=tolerance, rtol=0)

from collections import Counter

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.optimisation.least_squares import (
    BoundedGaussNewton,
    JacobianFunction,
    StepRules,
    finite_difference,
)

TIME = np.linspace(0.0, 4.0, 50)
FREE = (np.full(3, -10.0), np.full(3, 10.0))


class Counted:
    """Residuals of a decaying oscillation, their derivatives by differences, and how often each was asked."""

    def __init__(self, true: FloatArray) -> None:
        self.measured = self.model(true)
        self.calls = 0

    @staticmethod
    def model(u: FloatArray) -> FloatArray:
        return np.asarray(np.exp(u[0] - 0.3 * TIME * np.exp(u[1])) * np.cos(np.exp(u[2]) * TIME))

    def residual(self, u: FloatArray) -> FloatArray:
        self.calls += 1
        return 1e3 * (self.model(u) - self.measured)  # random error 1e-3

    @property
    def derivatives(self) -> JacobianFunction:
        step = 1e-6 * np.eye(3)
        return lambda u, here: np.array([(self.residual(u + one) - here) / 1e-6 for one in step]).T


def test_a_nonlinear_fit_comes_home_in_few_evaluations() -> None:
    true = np.array([0.1, 0.2, 0.3])
    problem = Counted(true)
    descent = BoundedGaussNewton(problem.residual, problem.derivatives, np.array([0.2, 0.0, 0.25]), FREE)
    descent.minimise(StepRules(evaluations=20, tolerance=1e-4))
    # Stops when a step promises 1e-4 of a squared error: within a hundredth of a standard error, 1e-3.
    np.testing.assert_allclose(descent.position, true, atol=1e-4)
    # Six steps at derivatives by differences alone would ask for 1 + 6 (3 + 1).
    assert problem.calls < 20


@pytest.mark.parametrize("apart", [1.0, 1e-2, 1e-5, 1e-7])
def test_a_linear_fit_is_exact_in_one_step_however_alike_two_columns_are(apart: float) -> None:
    rng = np.random.default_rng(0)
    first, other, data = rng.standard_normal((3, 200))
    jacobian = np.column_stack([1e3 * first, first + apart * other])  # of different sizes too

    def residual(u: FloatArray) -> FloatArray:
        return np.asarray(data - jacobian @ u)

    bounds = np.full(2, -1e9), np.full(2, 1e9)
    fit = BoundedGaussNewton(residual, lambda *_: -jacobian, np.zeros(2), bounds)
    step, gain = fit._step(1e9, None)
    best = np.linalg.lstsq(jacobian, data, rcond=None)[1][0]
    # Ten times what rounding, 1e-16, is over the least 1e-7. Products of such columns would be 1e-2 off.
    assert np.sum(residual(step) ** 2) == pytest.approx(best, rel=1e-8)
    assert gain == pytest.approx(data @ data - best, rel=1e-8)


def test_without_renewals_a_fit_ends_where_its_derivatives_mislead() -> None:
    true = np.array([0.1, 0.2, 0.3])
    problem = Counted(true)
    far = np.array([1.5, -1.0, 1.2])  # two oscillations off: the first derivatives serve for a few steps
    descent = BoundedGaussNewton(problem.residual, problem.derivatives, far, FREE)
    first = float(descent.vector @ descent.vector)
    descent.minimise(StepRules(evaluations=8, tolerance=1e-4, corrections=8, renewals=False))
    assert problem.calls <= 1 + 3 + 8  # the start, one Jacobian, a step each
    assert float(descent.vector @ descent.vector) <= first
    before = problem.calls
    descent.minimise(StepRules(evaluations=40, tolerance=1e-4))
    assert problem.calls > before + 3  # it goes on with new derivatives


def test_a_number_comes_to_lie_on_its_bound_and_the_others_make_the_best_of_it() -> None:
    true = np.array([0.1, 0.2, 0.3])
    bounds = (FREE[0], np.array([10.0, 0.1, 10.0]))
    problem = Counted(true)
    descent = BoundedGaussNewton(problem.residual, problem.derivatives, np.array([0.2, 0.0, 0.25]), bounds)
    descent.minimise(StepRules(evaluations=20, tolerance=1e-6))
    assert descent.position[1] == 0.1
    # What is free has no slope left: a residual of 1e3 times what is missed is orthogonal to it.
    jacobian = problem.derivatives(descent.position, descent.vector)[:, [0, 2]]
    left = jacobian.T @ descent.vector / np.linalg.norm(jacobian, axis=0)
    assert np.abs(left).max() < 0.1  # in standard errors


def test_where_nothing_can_be_predicted_a_step_is_cut_short() -> None:
    true = np.array([0.1, 0.2, 0.3])
    problem = Counted(true)

    asked = []

    def residual(u: FloatArray) -> FloatArray:
        asked.append(u[0])
        if u[0] > 0.15:
            raise InvalidInputError("beyond what can be predicted")
        return problem.residual(u)

    start = np.array([-0.8, 0.2, 0.3])  # from where the first step goes too far: amplitudes are exponents
    descent = BoundedGaussNewton(residual, problem.derivatives, start, FREE)
    descent.minimise(StepRules(evaluations=20, tolerance=1e-4))
    assert max(asked) > 0.15
    # As where all can be predicted: within a hundredth of a standard error, 1e-3.
    np.testing.assert_allclose(descent.position, true, atol=1e-4)


def test_weights_say_whose_errors_count() -> None:
    problem = Counted(np.array([0.1, 0.2, 0.3]))
    early = (TIME < 2.0).astype(float)
    problem.measured = problem.measured + (1 - early)  # nonsense where nothing counts
    descent = BoundedGaussNewton(problem.residual, problem.derivatives, np.array([0.2, 0.0, 0.25]), FREE)
    descent.minimise(StepRules(evaluations=20, tolerance=1e-4), early)
    np.testing.assert_allclose(descent.position, [0.1, 0.2, 0.3], atol=1e-3)  # half as many lines


def test_a_number_that_nothing_depends_on_stays_where_it_is() -> None:
    descent = BoundedGaussNewton(
        lambda u: np.array([u[0] - 3.0, 0.0 * u[1]]),
        lambda *_: np.array([[1.0, 0.0], [0.0, 0.0]]),
        np.array([0.0, 0.5]),
        (np.full(2, -10.0), np.full(2, 10.0)),
    )
    descent.minimise(StepRules(evaluations=10, tolerance=1e-4))
    assert descent.position == pytest.approx([3.0, 0.5])


def test_a_fit_ends_where_derivatives_promise_only_their_own_error() -> None:
    true, stated = np.array([[5.0], [0.0]]), np.array([[10.0], [0.1]])
    least = np.array([0.0, 30.0])  # what no parameter reduces; its mean square is 450
    evaluated = []

    def residual(u: FloatArray) -> FloatArray:
        evaluated.append(float(u[0]))
        return np.asarray(least + true @ u)

    bounds = np.array([-1.0]), np.array([1.0])
    descent = BoundedGaussNewton(residual, lambda *_: stated, np.zeros(1), bounds)
    # They promise (0.1 x 30 / 10)^2 = 0.09 by a step of 0.03, which in truth costs (5 x 0.03)^2 = 0.02.
    descent.minimise(StepRules(evaluations=20, tolerance=0.03 / 450))
    assert evaluated == pytest.approx([0.0, -0.03], rel=1e-3)  # 1 + (0.1 / 10)^2
    assert descent.position == 0.0


def test_a_fit_ends_where_errors_of_predictions_hide_what_steps_gain() -> None:
    evaluated = []

    def residual(u: FloatArray) -> FloatArray:
        evaluated.append(float(u[0]))
        error = 0.005 * (len(evaluated) > 1)  # costs 0.1 wherever a step leads
        return np.array([10.0 + error, u[0]])

    bounds = np.array([-1.0]), np.array([1.0])
    descent = BoundedGaussNewton(residual, lambda *_: np.array([[0.1], [1.0]]), np.zeros(1), bounds)
    descent.minimise(StepRules(evaluations=20, tolerance=1e-9, prediction_error=0.5))
    assert len(evaluated) == 4  # the start, a step that loses 1.1, and two that lose little
    assert descent.position == 0.0


def test_costly_derivatives_are_corrected_before_they_are_renewed() -> None:
    true, start = np.array([0.1, 0.2, 0.3]), np.array([-0.8, 0.2, 0.3])
    renewals = []
    for corrections in (1, 4):
        problem = Counted(true)
        n_renewed = 0

        def counted(u: FloatArray, here: FloatArray, problem: Counted = problem) -> FloatArray:
            nonlocal n_renewed
            n_renewed += 1
            return problem.derivatives(u, here)

        descent = BoundedGaussNewton(problem.residual, counted, start, FREE)
        descent.minimise(StepRules(evaluations=30, tolerance=1e-4, corrections=corrections))
        np.testing.assert_allclose(descent.position, true, atol=1e-4)  # a hundredth of a standard error, 1e-3
        renewals.append(n_renewed)
    assert renewals[1] < renewals[0]


def test_most_renewals_are_of_the_first_derivatives_alone() -> None:
    true, start = np.array([0.1, 0.2, 0.3]), np.array([-0.8, 0.2, 0.3])
    n_renewed = {}
    for partial_renewals in (0, 2):
        problem = Counted(true)
        asked = Counter[int]()

        def differentiate(
            n: int, problem: Counted = problem, asked: Counter[int] = asked
        ) -> JacobianFunction:
            def columns(u: FloatArray, here: FloatArray) -> FloatArray:
                asked[n] += 1
                return problem.derivatives(u, here)[:, :n]

            return columns

        descent = BoundedGaussNewton(
            problem.residual,
            differentiate(3),
            start,
            FREE,
            differentiate_first=differentiate(1),
            partial_renewals=partial_renewals,
        )
        assert descent.minimise(StepRules(evaluations=30, tolerance=1e-4))
        np.testing.assert_allclose(descent.position, true, atol=1e-4)  # a hundredth of a standard error, 1e-3
        n_renewed[partial_renewals] = asked
    assert n_renewed[0][1] == 0
    assert n_renewed[2][1] > 0
    assert n_renewed[2][3] < n_renewed[0][3]


def curved_valley(u: FloatArray) -> FloatArray:
    """Return residuals of a valley that bends: Rosenbrock, The Computer Journal 3 (1960), 175."""
    return np.array([10.0 * (u[1] - u[0] ** 2), 1.0 - u[0]])


def test_in_a_curved_valley_shorter_steps_save_renewals() -> None:
    renewals = {}
    for poor_steps in (0, 2):
        asked = Counter[int]()

        def slopes(u: FloatArray, _here: FloatArray, asked: Counter[int] = asked) -> FloatArray:
            asked[2] += 1
            return np.array([[-20.0 * u[0], 10.0], [-1.0, 0.0]])

        bounds = np.full(2, -5.0), np.full(2, 5.0)
        descent = BoundedGaussNewton(curved_valley, slopes, np.array([-1.2, 1.0]), bounds)
        descent.minimise(
            StepRules(
                evaluations=200, tolerance=1e-6, corrections=20, poor_steps=poor_steps, partial_renewals=False
            )
        )
        # A step that would gain 1e-6 squares is a thousandth of the weaker residual's standard error long.
        np.testing.assert_allclose(descent.position, [1.0, 1.0], atol=4e-3)
        renewals[poor_steps] = asked[2]
    assert renewals[2] < renewals[0]


def test_a_fit_ends_at_its_goal() -> None:
    problem = Counted(np.array([0.1, 0.2, 0.3]))
    descent = BoundedGaussNewton(problem.residual, problem.derivatives, np.array([0.2, 0.0, 0.25]), FREE)
    goal = float(descent.vector @ descent.vector) / 10
    assert not descent.minimise(StepRules(evaluations=20, tolerance=1e-4, goal=goal))
    assert 1e-4 * goal < float(descent.vector @ descent.vector) < goal


def test_a_slope_is_the_derivative_where_a_number_acts_in_a_straight_line() -> None:
    direction = np.array([3.0, -4.0])
    found = finite_difference(lambda step: direction * step, np.zeros(2), 1e-6, 0.1)
    np.testing.assert_allclose(found, direction)  # rounding


def test_where_residuals_are_flat_and_curved_a_slope_is_taken_over_what_can_be_seen() -> None:
    curved = np.array([3e6, 4e6])  # seen at one standard error from sqrt(1 / 5e6) on
    found = finite_difference(lambda step: curved * step**2, np.zeros(2), 3e-6, 0.1)
    # Over the step that changes the residuals by one: sqrt(5e6) a unit. By a factor of two it may be off.
    assert 0.5 < np.linalg.norm(found) / np.sqrt(5e6) < 2.0
    np.testing.assert_allclose(found[1] / found[0], 4 / 3)  # rounding


def test_a_number_that_nothing_depends_on_has_no_slope() -> None:
    assert (finite_difference(lambda _: np.ones(2), np.ones(2), 3e-6, 0.1) == 0).all()

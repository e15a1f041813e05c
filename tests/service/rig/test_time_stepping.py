from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.rig.local_force import LinearisedForce, LocalForce
from modallab.rig.nonlinear_settings import TIME_STEPPING
from modallab.rig.time_stepping import ModalFeedback, Stepper, check_bounded, residual_forces

M, F0, ZETA = 2.0, 20.0, 0.03  # one mode: kg, Hz, damping ratio
W0 = 2 * np.pi * F0
PERIOD, N = 1.0, 2048
TIME = PERIOD * np.arange(N) / N


def lines(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """A multisine of 60 lines: amplitudes in N, phases."""
    return np.full(60, 1.0), rng.uniform(0, 2 * np.pi, 60)


def push(t: FloatArray | float, amplitude: FloatArray, phase: FloatArray) -> FloatArray:
    k = np.arange(1, 61)
    angle = 2 * np.pi * np.multiply.outer(np.asarray(t), k) / PERIOD + phase
    return np.asarray(np.cos(angle) @ amplitude)


def stepped(one: LinearisedForce, force: FloatArray, periods: int) -> FloatArray:
    """The motion (n_samples,) of the last of some periods: straight line by frequency, the rest by steps."""
    freq = np.fft.rfftfreq(N, PERIOD / N)
    s = 2j * np.pi * freq
    k, c = (0.0, one.slope) if one.force.of_velocity else (one.slope, 0.0)
    receptance = 1 / (M * s**2 + (2 * ZETA * W0 * M + c) * s + M * W0**2 + k)
    moved = np.fft.irfft(receptance * np.fft.rfft(force))
    velocity = np.fft.irfft(s * receptance * np.fft.rfft(force))
    omega = np.sqrt(W0**2 + k / M)
    feedback = ModalFeedback(
        np.array([[1 / np.sqrt(M)]]), np.array([omega]), np.array([2 * ZETA * W0 + c / M])
    )
    taken = np.tile(velocity if one.force.of_velocity else moved, periods)[:, None, None, None]
    stepper = Stepper([feedback], [one.force.of_velocity], PERIOD / N)
    found = residual_forces([[one]], lambda start, end: taken[start:end], len(taken), stepper)
    residual = found[-N:, 0, 0, 0]
    return moved - np.fft.irfft(receptance * np.fft.rfft(residual))


def integrated(one: LinearisedForce, amplitude: FloatArray, phase: FloatArray, periods: int) -> FloatArray:
    """The same by scipy, to 1e-9."""

    def rate(t: float, y: FloatArray) -> list[float]:
        own = one.force.law(np.array([y[1] if one.force.of_velocity else y[0]]))[0]
        pull = float(push(t, amplitude, phase)) - 2 * ZETA * W0 * M * y[1] - M * W0**2 * y[0] - own
        return [y[1], pull / M]

    times = (periods - 1) * PERIOD + TIME
    found = solve_ivp(rate, (0, periods * PERIOD), [0.0, 0.0], "DOP853", times, rtol=1e-9, atol=1e-14)
    return np.asarray(found.y[0])


def rms_of(amplitude: FloatArray, phase: FloatArray) -> tuple[float, float]:
    freq = np.fft.rfftfreq(N, PERIOD / N)
    s = 2j * np.pi * freq
    line = np.fft.rfft(push(TIME, amplitude, phase)) / (M * s**2 + 2 * ZETA * W0 * M * s + M * W0**2)
    return float(np.fft.irfft(line).std()), float(np.fft.irfft(s * line).std())


@pytest.mark.parametrize("strength", [0.03, 0.3])
def test_a_cubic_spring_distorts_the_response_as_high_accuracy_integration_has_it(strength: float) -> None:
    amplitude, phase = lines(np.random.default_rng(3))
    rms, _ = rms_of(amplitude, phase)
    # so strong that its straight line is this share of the mode's own stiffness
    force = CubicStiffness(Dof(1, "Y"), strength * M * W0**2 / (3 * rms**2)).on_motion()
    assert force is not None
    one = force.linearised(rms)
    found = stepped(one, push(TIME, amplitude, phase), 8)
    wanted = integrated(one, amplitude, phase, 8)
    applied = np.fft.rfft(push(TIME, amplitude, phase))[1:61]
    frf, exact = (np.fft.rfft(x)[1:61] / applied for x in (found, wanted))
    s = 2j * np.pi * np.arange(1, 61)
    undistorted = 1 / (M * s**2 + 2 * ZETA * W0 * M * s + M * W0**2)
    distortion = np.abs(exact - undistorted)
    # straight lines between steps of 1/34 of the highest period: (2 pi/34)^2/12 = 0.3 % of the force there
    assert np.abs(frf - exact).max() < 0.01 * distortion.max()
    assert distortion.max() > 0.05 * np.abs(undistorted).max(), "there is something to get right"


def test_friction_too_follows_high_accuracy_integration() -> None:
    amplitude, phase = lines(np.random.default_rng(4))
    _, rms = rms_of(amplitude, phase)
    force = Friction(Dof(1, "Y"), 0.5, 0.05 * rms).on_motion()
    assert force is not None
    one = force.linearised(rms)
    found, wanted = stepped(one, push(TIME, amplitude, phase), 8), integrated(one, amplitude, phase, 8)
    # the step of the law is passed within some steps of time: 1 % of the motion
    assert np.abs(found - wanted).max() < 0.01 * np.abs(wanted).max()


def series(n: int, shape: tuple[int, ...]) -> FloatArray:
    return 0.01 * np.random.default_rng(5).standard_normal((n, *shape))


def residuals_of(
    feedbacks: list[ModalFeedback], found: list[list[LinearisedForce]], moved: FloatArray, block: int = 16
) -> FloatArray:
    stepper = Stepper(feedbacks, [one.force.of_velocity for one in found[0]], 1e-3, block)
    return residual_forces(found, lambda start, end: moved[start:end], len(moved), stepper)


TWO = ModalFeedback(np.array([[0.7, 0.4], [0.2, -0.9]]), np.array([30.0, 70.0]), np.array([1.5, 2.8]))
SPRING = LocalForce(Dof(1, "Y"), lambda x: 1e5 * x**3, lambda x: 3e5 * x**2, degree=3)


def test_forces_at_several_motions_are_solved_for_together() -> None:
    moved = series(50, (1, 3, 2))
    both = residuals_of([TWO], [[SPRING.linearised(0.01)] * 2], moved)
    turned = residuals_of(
        [replace(TWO, shapes=TWO.shapes[::-1])], [[SPRING.linearised(0.01)] * 2], moved[..., ::-1].copy()
    )
    np.testing.assert_allclose(both, turned[..., ::-1], rtol=1e-9, atol=1e-15)


def test_runs_side_by_side_are_what_each_is_alone() -> None:
    """Structures with different numbers of modes, forces at different motions."""
    one = ModalFeedback(TWO.shapes[:, :1], TWO.omega[:1], TWO.damping[:1])
    found = [
        [SPRING.linearised(0.01), SPRING.linearised(0.008)],
        [SPRING.linearised(0.02), SPRING.linearised(0.011)],
    ]
    moved = series(70, (2, 3, 2))
    together = residuals_of([one, TWO], found, moved)
    for i, feedback in enumerate((one, TWO)):
        alone = residuals_of([feedback], [found[i]], moved[:, i : i + 1])
        np.testing.assert_allclose(together[:, i : i + 1], alone, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("n_forces", [1, 2])
def test_the_length_of_a_block_changes_nothing(n_forces: int) -> None:
    feedback = replace(TWO, shapes=TWO.shapes[:n_forces])
    found, moved = [[SPRING.linearised(0.01)] * n_forces], series(70, (1, 3, n_forces))
    step_by_step, blocks = (residuals_of([feedback], found, moved, block) for block in (1, 16))
    # rounding alone
    np.testing.assert_allclose(blocks, step_by_step, rtol=1e-9, atol=1e-12 * np.abs(blocks).max())
    assert np.abs(blocks).max() > 0


def held_by_friction(share: float) -> tuple[ModalFeedback, LinearisedForce]:
    """Two modes at 0.1 % and a brake whose straight line is this share of what would stop the first."""
    law = Friction(Dof(1, "Y"), 1.0, 1e-6).on_motion()
    assert law is not None
    shapes, omega = np.array([[0.7, 0.9]]), np.array([30.0, 40.0])
    line = share * 2 * omega[0] / shapes[0, 0] ** 2
    one = law.linearised(np.sqrt(2 / np.pi) / line)  # f sqrt(2/pi)/s, well above sticking
    return ModalFeedback(shapes, omega, 2e-3 * omega + one.slope * shapes[0] ** 2), one


@pytest.mark.parametrize(("share", "refused"), [(0.05, False), (0.5, True)])
def test_what_is_refused_as_too_hard_a_hold_grows_in_steps_and_nothing_else_does(
    share: float, refused: bool
) -> None:
    feedback, one = held_by_friction(share)
    moved = np.zeros((20_000, 1, 1, 1))  # 20 s: what a push begins is forgotten
    moved[:1000] = (
        2 * TIME_STEPPING.loud_ratio * one.rms * np.sin(35.0 * 1e-3 * np.arange(1000))[:, None, None, None]
    )
    left = np.abs(residuals_of([feedback], [[one]], moved)[:, 0, 0, 0])
    if refused:
        with pytest.raises(DivergedError, match="1:\\+Y holds too hard"):
            check_bounded(feedback, [one])
        assert left[-1000:].max() > 100 * left[:1000].max()
    else:
        check_bounded(feedback, [one])
        assert left[-1000:].max() < left[:1000].max()


def test_a_single_mode_is_held_as_hard_as_one_likes() -> None:
    """What its damper takes off again at loud motions is what the damper was: nothing is shared."""
    for share in (0.5, 50.0):
        both, one = held_by_friction(share)
        check_bounded(ModalFeedback(both.shapes[:, :1], both.omega[:1], both.damping[:1]), [one])

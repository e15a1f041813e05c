"""Estimates that a measurement keeps while its averages are taken."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.rig.estimates import Estimates
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, rig, steel_beam

SMALL = {"frequency_max": 200.0, "n_lines": 101, "averages": 20}
SINGLE = 1e-6  # rounding of single precision, of real and imaginary part


def measured(
    setup: RigSetup, estimates: int = 20, seed: int = 1, route: Route = Route.SAMPLED
) -> Measurement:
    return measure(steel_beam(), setup, route=route, rng=np.random.default_rng(seed), estimates=estimates)


def kept(measurement: Measurement) -> Estimates:
    assert measurement.estimates is not None
    return measurement.estimates


def shorter(setup: RigSetup, averages: int) -> RigSetup:
    """The same rig with fewer averages."""
    return replace(setup, analyser=replace(setup.analyser, averages=averages))


@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
@pytest.mark.parametrize(("excitation", "window"), [("random", "hann"), ("burst_random", "rectangular")])
def test_an_estimate_is_the_measurement_of_as_many_averages(
    excitation: str, window: str, estimator: str
) -> None:
    analyser = SMALL | {"window": window, "estimator": estimator}
    setup = rig(1, 7, excitation=excitation, noise=Noise(1e-2, 1e-2), analyser=analyser)
    test = measure(steel_beam(), setup, rng=np.random.default_rng(1), estimates=20, records=20)
    assert kept(test).n_averages.tolist() == list(range(1, 20))
    assert test.records is not None
    window_of_lines = setup.analyser.line_window.weights(test.records.force.shape[1], 1, 1)
    for count in (2, 7, 19):
        force = np.fft.rfft(window_of_lines[0] * test.records.force[:count, :, 0, 0])[:, :101]
        response = np.fft.rfft(window_of_lines[1] * test.records.response[:count, :, 0, 1])[:, :101]
        cross = (force.conj() * response).mean(axis=0)
        ff, xx = (np.abs(force) ** 2).mean(axis=0), (np.abs(response) ** 2).mean(axis=0)
        expected = {"h1": cross / ff, "h2": xx / cross.conj(), "hv": np.sqrt(xx / ff) * cross / np.abs(cross)}
        estimate = kept(test)
        np.testing.assert_allclose(estimate.values[count - 1, :, 1, 0], expected[estimator], rtol=SINGLE)
        np.testing.assert_allclose(
            estimate.coherence[count - 1, :, 1], np.abs(cross) ** 2 / ff / xx, rtol=SINGLE
        )


def test_estimates_change_nothing_of_the_measurement() -> None:
    setup = rig(1, 7, excitation="random", analyser=SMALL | {"window": "hann", "overlap": 0.5})
    watched, unwatched = measured(setup, 7), measured(setup, 0)
    assert unwatched.estimates is None
    assert kept(watched).values.shape == (6, *watched.frf.values.shape)
    np.testing.assert_array_equal(watched.frf.values, unwatched.frf.values)
    np.testing.assert_array_equal(watched.coherence, unwatched.coherence)


def test_the_coherence_of_one_average_is_one_whatever_the_noise() -> None:
    test = measured(rig(1, 7, noise=Noise(0.1, 1.0), analyser=SMALL))
    assert test.coherence is not None
    np.testing.assert_allclose(kept(test).coherence[0], 1.0, rtol=SINGLE)
    assert np.median(test.coherence) < 0.7


def test_random_error_falls_with_the_square_root_of_the_averages() -> None:
    """Of H1 with noise on the response alone: its variance is the noise over n - 1 times the force.

    The mean of one over a sum of n squares of complex Gaussian numbers of power 1 is 1/(n - 1).
    """
    setup = rig(1, 7, noise=Noise(0.0, 0.1), analyser=SMALL | {"averages": 80})
    exact = measured(replace(setup, noise=Noise()), 0, route=Route.EXPECTED).frf.values[1:]
    tests = [measured(setup, 24, seed) for seed in range(6)]
    counts = kept(tests[0]).n_averages
    errors = np.array([kept(test).values[:, 1:] - exact for test in tests])
    variance = (np.abs(errors) ** 2).mean(axis=(0, 3, 4))
    scaled = variance * (counts - 1)[:, None]
    use = counts >= 8  # below, a few lines with hardly any force have all of the variance
    # 1,200 errors, each of them with a power that scatters by itself or a little more: 3 %; four of these
    level = scaled[use].mean(axis=0)
    np.testing.assert_allclose((scaled[use] / level).mean(axis=1), 1.0, rtol=0.12)


def test_coherence_settles_from_above() -> None:
    """Its bias is (1 - g2)^2/n; Bendat and Piersol (2010), eq. (9.77)."""
    setup = rig(1, 7, noise=Noise(0.0, 1.0), analyser=SMALL | {"averages": 100})
    true = measured(setup, 0, route=Route.EXPECTED).coherence
    assert true is not None
    tests = [kept(measured(setup, 3, seed)) for seed in range(6)]
    assert tests[0].n_averages.tolist() == [1, 10]
    found = np.mean([test.coherence[1] for test in tests])
    # scatter of 1,200 values of up to 0.2 each, 0.006, and the terms of second order, (1/10)^2
    assert found == pytest.approx(np.mean(true + (1 - true) ** 2 / 10), abs=0.02)


def test_estimates_of_a_roving_test_are_those_of_all_runs() -> None:
    hammer = rig(
        1, 7, exciter=Exciter("hammer"), excitation="impact", analyser=SMALL, noise=Noise(1e-3, 1e-3)
    )
    roving = replace(hammer, drives=dofs(1, 7))
    test = measured(roving, 4)
    assert kept(test).coherence.shape == (3, 101, 2, 2)
    moved = measured(rig(1, 7, 13, accelerometers=Accelerometers(mass=0.02, roving=True), analyser=SMALL), 4)
    assert kept(moved).values.shape == (3, 101, 3, 1)


def test_two_forces_are_told_apart_from_two_averages_on() -> None:
    setup = replace(rig(1, 7, 13, analyser=SMALL, noise=Noise(1e-2, 1e-2)), drives=dofs(1, 7))
    test = measured(setup, 20)
    first = kept(test)
    assert first.n_averages[0] == 2
    np.testing.assert_allclose(first.coherence[0], 1.0, rtol=1e-5)  # single precision, of a solution


def test_lines_below_the_first_are_in_no_estimate() -> None:
    test = measured(rig(1, analyser=SMALL | {"frequency_min": 50.0, "n_lines": 76}), 3)
    assert kept(test).values.shape == (2, 76, 1, 1)


def test_one_average_is_all_there_is() -> None:
    assert len(kept(measured(rig(1, analyser=SMALL | {"averages": 1}), 5))) == 0


@pytest.mark.parametrize("route", [Route.EXPECTED, Route.DRAWN])
def test_a_route_without_averages_in_turn_keeps_none(route: Route) -> None:
    with pytest.raises(InvalidInputError, match="only the route sampled"):
        measured(rig(1, analyser=SMALL), 3, route=route)


def test_estimates_of_more_values_than_the_limit_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="can be kept") as caught:
        measured(rig(*range(1, 22), analyser={"n_lines": 6401}), 10)
    assert caught.value.context["allowed"] == {"minimum": 0, "maximum": 2**19 // (21 * 6401) + 1}

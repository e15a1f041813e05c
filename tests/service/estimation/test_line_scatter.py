"""Tests of random errors estimated from the scatter of neighbouring lines."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.line_scatter import estimated_averages, estimated_error, likeliest_window
from modallab.estimation.windows import WINDOWS
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.diagnosing import model, rig


def measured(averages: int, kind: str, window: str, seed: int, *, roving: bool = True) -> Measurement:
    setup = rig(kind=kind, window=window, averages=averages, roving=roving)
    analyser = replace(setup.analyser, n_lines=801, excitation=ExcitationSetting(kind))
    setup = replace(setup, analyser=analyser, noise=Noise(1e-3, 1e-3))
    return measure(model(), setup, route=Route.SAMPLED, rng=np.random.default_rng(seed))


def frfs(test: Measurement) -> ComplexArray:
    return np.asarray(test.frf.values[1:, :, 0], complex)


@pytest.mark.parametrize(
    ("kind", "window"),
    [
        ("periodic_random", "rectangular"),
        ("random", "hann"),
        ("impact", "rectangular"),
        ("impact", "exponential"),
    ],
)
@pytest.mark.parametrize(
    ("averages", "roving"), [(3, True), (5, False), (10, True), (40, False), (200, True)]
)
def test_coherence_and_scatter_tell_the_averages(averages: int, kind: str, window: str, roving: bool) -> None:
    test = measured(averages, kind, window, averages, roving=roving)
    assert test.coherence is not None
    estimate = estimated_averages(frfs(test), test.coherence[1:], WINDOWS[window])
    assert estimate is not None
    # three standard errors, and 5 % for resonances that a local model misses, and for leakage
    tolerance = 3 * estimate.standard_error + 0.05 * averages
    assert estimate.value == pytest.approx(averages, abs=tolerance)
    assert estimate.standard_error < 0.12 * averages  # 47 stretches of 6 FRFs with 24 degrees of freedom


@pytest.mark.parametrize(
    ("kind", "window", "random_force"),
    [("periodic_random", "rectangular", False), ("random", "hann", True), ("impact", "exponential", False)],
)
def test_lines_show_an_undeclared_window(kind: str, window: str, random_force: bool) -> None:
    test = measured(5, kind, window, 3)
    assert test.coherence is not None
    estimate = estimated_averages(frfs(test), test.coherence[1:], None)
    assert estimate is not None
    assert estimate.value == pytest.approx(5, abs=3 * estimate.standard_error + 0.25)  # as above
    correlation = estimate.correlation
    assert correlation.window.coefficients == WINDOWS[window].coefficients
    if window == "exponential":
        # 12,000 residuals tell the decay to some per cent, and ln(end) = -4.6
        assert np.log(correlation.window.end) == pytest.approx(np.log(WINDOWS[window].end), rel=0.07)
        assert correlation.delay == pytest.approx(test.setup.analyser.excitation.pre_trigger, abs=0.015)
    elif window == "hann":
        assert correlation.random_force is random_force


@pytest.mark.parametrize("declared", ["rectangular", "hann", "flat_top"])
@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
@pytest.mark.parametrize("seed", [1, 2])
def test_lines_show_the_window_whatever_is_declared(kind: str, window: str, seed: int, declared: str) -> None:
    test = measured(40, kind, window, seed)
    assert test.coherence is not None
    assert likeliest_window(frfs(test), test.coherence[1:], test.averages, declared) == window


def test_too_few_lines_leave_the_declared_window() -> None:
    test = measured(40, "random", "hann", 1)
    assert test.coherence is not None
    few = slice(300, 334)  # two stretches of 17 lines
    assert (
        likeliest_window(frfs(test)[few, :1], test.coherence[1:][few, :1], 40, "rectangular") == "rectangular"
    )


@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
def test_twelve_stretches_of_one_frf_show_the_window(kind: str, window: str) -> None:
    """A hidden leakage was called a cubic stiffness: Hann was ahead by 1.5 standard errors, not by 2.5."""
    test = measured(40, kind, window, 1)
    assert test.coherence is not None
    some = slice(200, 404)
    lines, coherence = frfs(test)[some, :1], test.coherence[1:][some, :1]
    assert likeliest_window(lines, coherence, 40, "rectangular") == window


# Tests in which Hann is ahead by 2.0 to 2.5 standard errors.
@pytest.mark.parametrize(("first", "seed"), [(336, 1), (480, 2), (480, 4)])
def test_seven_stretches_show_a_hann_window(first: int, seed: int) -> None:
    test = measured(40, "random", "hann", seed)
    assert test.coherence is not None
    few = slice(first, first + 136)  # eight stretches of 17 lines, of which seven are plausible
    assert likeliest_window(frfs(test)[few, :1], test.coherence[1:][few, :1], 40, "rectangular") == "hann"


def test_lines_without_random_errors_leave_the_declared_window() -> None:
    """Residuals of exact lines with a coherence below 1 are those of the local model, which are smooth."""
    setup = measured(40, "periodic_random", "rectangular", 1).setup
    test = measure(model(), setup, route=Route.EXPECTED, rng=np.random.default_rng(0))
    assert test.coherence is not None
    assert likeliest_window(frfs(test), test.coherence[1:], 40, "rectangular") == "rectangular"


def test_a_coherence_of_one_leaves_the_declared_window() -> None:
    assert likeliest_window(np.ones((200, 2), complex), np.ones((200, 2)), 40, "hann") == "hann"


def test_scatter_alone_tells_the_random_error() -> None:
    test = measured(100, "pseudo_random", "rectangular", 3)
    exact = measure(model(), test.setup, route=Route.EXPECTED, rng=np.random.default_rng(0))
    difference = (test.frf.values - exact.frf.values)[1:, :, 0]
    true = np.sqrt(np.median(np.abs(difference) ** 2, axis=0) / (2 * np.log(2)))
    true /= np.median(np.abs(test.frf.values[1:, :, 0]), axis=0)
    errors = estimated_error(frfs(test), WINDOWS["rectangular"])
    assert errors is not None
    # the noise is no constant over the lines: medians of lines and of stretches differ somewhat
    np.testing.assert_allclose([error.value for error in errors], true, rtol=0.2)


def test_a_coherence_of_one_has_no_random_error() -> None:
    values = np.ones((200, 2), complex)
    assert estimated_averages(values, np.ones((200, 2)), WINDOWS["rectangular"]) is None


def test_too_few_lines_are_refused_by_the_name_of_averages() -> None:
    values = np.linspace(1, 2, 30)[:, None].astype(complex)
    with pytest.raises(InvalidInputError) as caught:
        estimated_averages(values, np.full((30, 1), 0.9), WINDOWS["rectangular"])
    assert caught.value.context["field"] == "averages"

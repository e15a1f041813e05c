"""What every window must be: a shape in time and the same shape over lines."""

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS

KINDS = [kind for kind in sorted(WINDOWS) if not WINDOWS[kind].transient]
TRANSIENT = [kind for kind in sorted(WINDOWS) if WINDOWS[kind].transient]


@pytest.mark.parametrize("kind", KINDS)
def test_power_is_the_mean_square_of_the_samples(kind: str) -> None:
    window = WINDOWS[kind]
    assert np.isclose((window.samples(512) ** 2).mean(), window.power, rtol=1e-14)  # rounding


@pytest.mark.parametrize("kind", KINDS)
def test_the_line_shape_is_the_transform_of_the_samples(kind: str) -> None:
    window, n, zoom = WINDOWS[kind], 4096, 16
    amplitude = np.abs(np.fft.rfft(window.samples(n), n * zoom))[: 10 * zoom + 1] / n
    offset = np.arange(10 * zoom + 1) / zoom
    # n samples give sin(pi x)/(n sin(pi x/n)) for sinc x: (pi x/n)^2/3 = 2e-5 of 1e-3 at ten lines
    np.testing.assert_allclose(amplitude**2 / window.power, window.line_shape(offset), atol=1e-7)


@pytest.mark.parametrize("n", [18, 64])
@pytest.mark.parametrize("kind", [*KINDS, *TRANSIENT])
def test_the_line_shape_of_sampled_records_is_the_transform_of_the_samples(kind: str, n: int) -> None:
    window, rng = WINDOWS[kind], np.random.default_rng(n)
    whole = np.arange(-n, n + 1.0)  # where it comes again, too
    offset = np.concatenate([rng.uniform(-n, n, 300), whole])
    turned = window.samples(n) * np.exp(-2j * np.pi * np.outer(offset, np.arange(n)) / n)
    wanted = np.abs(turned.mean(axis=1)) ** 2 / window.power
    np.testing.assert_allclose(window.line_shape(offset, n), wanted, atol=1e-10)  # rounding beside a 0/0


@pytest.mark.parametrize("kind", KINDS)
def test_the_quick_form_holds_for_sampled_records(kind: str) -> None:
    window, n, lines = WINDOWS[kind], 64, np.arange(26.0)
    place = np.random.default_rng(1).uniform(-25, 25, 300)
    plain = window.line_shape(lines[:, None] - place, n)
    # the sine loses what its argument has of digits, beside the poles: as below
    np.testing.assert_allclose(window.line_shapes(lines, place, n), plain, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_the_line_shape_has_unit_area(kind: str) -> None:
    window = WINDOWS[kind]
    edge, points = 2000.0, 400_001
    offset = np.linspace(-edge, edge, points)
    area = np.trapezoid(window.line_shape(offset), offset)
    # a rectangular record's tails fall as 1/(pi x)^2, half of it on the average: 1/(pi^2 edge) lies beyond
    assert np.isclose(area, 1.0, rtol=1.1 / (np.pi**2 * edge) if kind == "rectangular" else 1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_lines_see_what_repeats_with_the_record_once(kind: str) -> None:
    lines = np.arange(-50.0, 51.0)
    assert np.isclose(WINDOWS[kind].line_shape(lines).sum(), 1.0, rtol=1e-13)  # Parseval; rounding


@pytest.mark.parametrize("kind", KINDS)
def test_the_quick_form_of_the_line_shape_is_the_plain_one(kind: str) -> None:
    window, lines = WINDOWS[kind], np.arange(40.0)
    place = np.concatenate([np.linspace(-3.3, 43.7, 301), 7 + np.array([-1e-3, 1e-3])])
    plain = window.line_shape(lines[:, None] - place)
    # sin(pi x) near a whole x loses what x has of digits: 1e-16 * 40 / 1e-3, of the largest
    np.testing.assert_allclose(window.line_shapes(lines, place), plain, atol=1e-12)


@pytest.mark.parametrize("kind", TRANSIENT)
def test_a_window_of_transients_weighs_responses_as_its_line_shape_says(kind: str) -> None:
    window, n = WINDOWS[kind], 4096
    lines = np.abs(np.fft.rfft(window.samples(n))[:11] / n) ** 2 / window.power
    # a sum of n samples for an integral: half of the jump between the ends, 0.5/n, of 0.2, and squared
    np.testing.assert_allclose(lines, window.line_shape(np.arange(11.0)), rtol=6 / n, atol=1e-7)


@pytest.mark.parametrize("kind", TRANSIENT)
def test_a_window_of_transients_leaves_the_start_of_a_record_and_takes_noise(kind: str) -> None:
    window = WINDOWS[kind]
    weights = window.weights(1000, 1, 2)
    np.testing.assert_array_equal(weights[:, 0], 1.0)
    assert (np.diff(weights, axis=1) <= 0).all()
    shares = window.noise_shares(1, 2)
    assert shares[0] < 1
    assert shares[1] == shares[2] >= shares[0]
    if window.end < 1:  # the mean of exp(-2 sigma t) over the record; samples for an integral
        assert np.isclose(shares[1], (1 - window.end**2) / (-2 * np.log(window.end)), rtol=2e-3)
    if window.force_width < 1:
        assert (weights[0, int(1000 * window.force_width) :] < 1e-9).all()

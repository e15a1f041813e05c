"""What every window must be: a shape in time and the same shape over lines."""

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS

KINDS = sorted(WINDOWS)


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

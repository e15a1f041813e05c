"""One FRF as magnitude and phase, and in the complex plane."""

from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib import pyplot

from modallab_client.models import Frf
from tests.client.test_drawing import measurement

LINES = np.linspace(0.0, 20.0, 201)
# inertance of a mass of 1 kg on a spring, loss factor 0.1, resonance at 10 Hz
RESONANCE = Frf(
    LINES,
    (-((2 * np.pi * LINES) ** 2) / ((2 * np.pi) ** 2 * (100.0 * (1 + 0.1j) - LINES**2)))[:, None, None],
    ("1:+Y",),
    ("1:+Y",),
    "inertance",
)


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def test_a_bode_plot_has_the_phase_of_90_degrees_at_resonance() -> None:
    upper, lower = RESONANCE.plot_bode()
    freq, phase = lower.lines[0].get_data()
    assert np.asarray(phase)[np.argmin(np.abs(np.asarray(freq) - 10.0))] == pytest.approx(90.0)
    assert np.asarray(freq)[0] > 0
    assert upper.get_ylabel() == "|inertance|, m/(s² N)"
    assert upper.get_title() == "1:+Y / 1:+Y"


def test_a_nyquist_plot_of_a_band_is_its_part_of_the_circle() -> None:
    axes = RESONANCE.plot_nyquist(band=(9.0, 11.0))
    real, imaginary = (np.asarray(part) for part in axes.lines[0].get_data())
    assert len(real) == 21  # lines 0.1 Hz apart
    assert np.max(imaginary) == pytest.approx(10.0, rel=1e-9)  # 1/(mass x loss factor)


def test_a_measurement_has_both_for_every_response() -> None:
    test = measurement()
    np.testing.assert_array_equal(test.plot_nyquist("3:+Y").lines[0].get_xdata(), test.values[1:, 1, 0].real)
    assert test.plot_bode("3:+Y")[0].get_title() == "3:+Y / 1:+Y"
    with pytest.raises(ValueError, match="there is no response 9:\\+Y: there are 1:\\+Y, 3:\\+Y"):
        test.plot_bode("9:+Y")
    with pytest.raises(ValueError, match="there is no force 9"):
        test.plot_nyquist(None, "9:+Y")

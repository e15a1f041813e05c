import numpy as np
import pytest

from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit, fit_mode


@pytest.mark.parametrize("bandwidth", [0.2, 1.0, 5.0])
def test_mode_and_residual_come_from_one_linear_problem(bandwidth: float) -> None:
    mode = ModeFit(100.3, bandwidth / 100.3, 1 + 0.1j, 1e-4 - 5e-5j)
    freq = np.arange(95.0, 106.0)
    found = fit_mode(EXTRACTION_METHODS["linear_fit"], freq, mode.response(freq))
    # rounding, multiplied by what a residual as large as the mode and two lines on the peak leave
    assert found.frequency == pytest.approx(100.3, rel=1e-10)
    assert found.loss_factor == pytest.approx(mode.loss_factor, rel=1e-7)
    assert found.modal_constant == pytest.approx(mode.modal_constant, rel=1e-7)
    assert found.residual == pytest.approx(mode.residual, rel=1e-6)


def test_four_lines_are_enough_wherever_they_lie() -> None:
    mode = ModeFit(100.3, 0.01, 1 + 0.1j, 1e-5)
    freq = np.array([93.0, 99.5, 100.5, 112.0])  # unequal steps
    found = fit_mode(EXTRACTION_METHODS["linear_fit"], freq, mode.response(freq))
    assert found.loss_factor == pytest.approx(0.01, rel=1e-8)  # rounding through the fit

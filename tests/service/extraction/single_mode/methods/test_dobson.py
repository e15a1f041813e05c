import numpy as np
import pytest

from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit, fit_mode


def test_an_imaginary_modal_constant_needs_no_branch() -> None:
    # n_R = Re(1/A) is zero here, by which the formula in real quantities divides
    mode = ModeFit(100.3, 0.01, 1j)
    freq = np.arange(95.0, 106.0)
    found = fit_mode(EXTRACTION_METHODS["dobson"], freq, mode.response(freq))
    assert found.modal_constant == pytest.approx(1j, rel=1e-9)  # rounding through the fit
    assert found.loss_factor == pytest.approx(0.01, rel=1e-9)


def test_a_line_on_the_resonance_itself_is_no_trouble() -> None:
    mode = ModeFit(100.0, 0.01, 1 + 0.1j)
    freq = np.arange(95.0, 106.0)
    found = fit_mode(EXTRACTION_METHODS["dobson"], freq, mode.response(freq))
    assert found.frequency == pytest.approx(100.0, rel=1e-12)

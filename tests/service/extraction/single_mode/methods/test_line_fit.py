import numpy as np
import pytest

from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit, fit_mode


def test_a_residual_far_larger_than_the_mode_is_taken_off_first() -> None:
    mode = ModeFit(100.3, 0.01, 1 + 0.1j, 1e-2 - 5e-3j)  # the mode's own peak is 2.5e-4 m/N
    freq = np.arange(95.0, 106.0)
    found = fit_mode(EXTRACTION_METHODS["line_fit"], freq, mode.response(freq))
    # 1e-16 of the residual is 1e-14 of the mode; the fit multiplies it by a few hundred
    assert found.loss_factor == pytest.approx(0.01, rel=1e-8)
    assert found.residual == pytest.approx(1e-2 - 5e-3j, rel=1e-9)


def test_a_line_where_mode_and_residual_cancel_is_left_out() -> None:
    bare = ModeFit(100.3, 0.01, 1 + 0.1j)
    freq = np.arange(95.0, 106.0)
    residual = -complex(bare.response(freq)[2])
    found = fit_mode(EXTRACTION_METHODS["line_fit"], freq, bare.response(freq) + residual)
    assert found.loss_factor == pytest.approx(0.01, rel=1e-9)  # rounding through the fit

"""What every estimator must do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.estimator import ESTIMATORS, MULTIPLE_INPUT_ESTIMATORS
from modallab.estimation.spectra import CrossSpectra

KINDS = sorted(ESTIMATORS)
FREQ = np.array([0.0, 1.0, 2.0])
H = np.array([[0.2, -3.0], [1 - 2j, 0.1j], [-5.0, 1e-3 + 1e-4j]])
ONE_FORCE = [kind for kind in KINDS if kind not in MULTIPLE_INPUT_ESTIMATORS]


def spectra(
    h: ComplexArray = H,
    force_noise: float = 0.0,
    response_noise: float = 0.0,
    gain: tuple[float, float] = (1, 1),
) -> CrossSpectra:
    """Spectra of one run; noise as a ratio to the signal of each line."""
    force = np.array([2.0, 1.0, 0.1])[:, None]
    signal: FloatArray = np.abs(h) ** 2 * force
    f, x = gain
    return CrossSpectra(
        FREQ,
        (f**2 * force * (1 + force_noise))[None, :, :, None].astype(complex),
        (f * x * force * h)[None, :, None, :],
        (x**2 * signal * (1 + response_noise))[None],
        100,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_without_noise_the_frf_itself_comes_back(kind: str) -> None:
    np.testing.assert_allclose(ESTIMATORS[kind](spectra())[0, :, :, 0], H, rtol=1e-14)  # rounding


@pytest.mark.parametrize("kind", KINDS)
@given(st.floats(0.01, 100), st.floats(0.01, 100))
def test_the_frf_follows_the_gains_of_the_channels(kind: str, f: float, x: float) -> None:
    plain = ESTIMATORS[kind](spectra(force_noise=0.3, response_noise=0.2))
    scaled = ESTIMATORS[kind](spectra(force_noise=0.3, response_noise=0.2, gain=(f, x)))
    np.testing.assert_allclose(scaled, plain * x / f, rtol=1e-13)  # rounding


@pytest.mark.parametrize("kind", KINDS)
@given(st.floats(0, 10), st.floats(0, 10))
def test_noise_leaves_the_phase_and_puts_the_size_between_h1_and_h2(
    kind: str, r_i: float, r_o: float
) -> None:
    ratio = ESTIMATORS[kind](spectra(force_noise=r_i, response_noise=r_o))[0, :, :, 0] / H
    np.testing.assert_allclose(ratio.imag, 0, atol=1e-14)  # rounding
    # 1992 thesis, eq. [5.6], [5.7]
    assert (ratio.real >= 1 / (1 + r_i) * (1 - 1e-14)).all()
    assert (ratio.real <= (1 + r_o) * (1 + 1e-14)).all()


@pytest.mark.parametrize("kind", ONE_FORCE)
def test_two_forces_at_once_are_refused_by_what_is_defined_for_one(kind: str) -> None:
    two = CrossSpectra(
        FREQ,
        np.tile(np.eye(2, dtype=complex), (1, 3, 1, 1)),
        np.ones((1, 3, 2, 1), complex),
        np.ones((1, 3, 1)),
        9,
    )
    with pytest.raises(ValueError, match="one force"):
        ESTIMATORS[kind](two)

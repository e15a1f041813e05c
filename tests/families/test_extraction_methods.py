"""What every single-mode method must do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import NoModeInBandError
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFit,
    Outcome,
    fit_mode,
)

modes = st.builds(
    ModeFit,
    frequency=st.floats(20, 500),
    loss_factor=st.floats(1e-3, 0.05),
    modal_constant=st.builds(complex, st.floats(0.1, 10), st.floats(-0.3, 0.3)),
)
residuals = st.complex_numbers(max_magnitude=1e-6)
KINDS = sorted(EXTRACTION_METHODS)
EXACT = [kind for kind in KINDS if EXTRACTION_METHODS[kind].exact]


def lines_of(mode: ModeFit, n_lines: int = 24, widths: float = 4.0) -> FloatArray:
    half = widths * mode.frequency * mode.loss_factor
    return np.linspace(mode.frequency - half, mode.frequency + half, n_lines)


@pytest.mark.parametrize("kind", EXACT)
@given(mode=modes, residual=residuals)
@settings(max_examples=60, deadline=None)
def test_a_single_mode_is_recovered_and_a_constant_residual_drops_out(
    kind: str, mode: ModeFit, residual: complex
) -> None:
    freq = lines_of(mode)
    found = fit_mode(EXTRACTION_METHODS[kind], freq, mode.response(freq) + residual)
    # clean data leave rounding only; these are the promises to the user, a thousand times wider
    assert np.isclose(found.frequency, mode.frequency, rtol=1e-6)
    assert np.isclose(found.loss_factor, mode.loss_factor, rtol=1e-3)
    assert np.isclose(found.modal_constant, mode.modal_constant, rtol=1e-3)


def noisy(
    freq: FloatArray, mode: ModeFit, relative: float, n_fits: int, seed: int
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    rng = np.random.default_rng(seed)
    clean = np.broadcast_to(mode.response(freq), (n_fits, len(freq)))
    variance = (relative * np.abs(clean)) ** 2
    error = rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape)
    return np.broadcast_to(freq, clean.shape), clean + np.sqrt(variance / 2) * error, 1 / variance


@pytest.mark.parametrize("kind", EXACT)
@pytest.mark.parametrize("bandwidth", [0.12, 1.0, 4.0])
def test_standard_errors_are_the_scatter_of_repeated_tests(kind: str, bandwidth: float) -> None:
    mode = ModeFit(100.37, bandwidth / 100.37, 1 + 0.2j, 1e-6 + 1e-6j)
    fits = EXTRACTION_METHODS[kind](*noisy(np.arange(97.0, 105.0), mode, 0.01, 1000, seed=5))
    assert fits.found.all()
    scores = {
        "frequency": (fits.frequency - mode.frequency) / fits.frequency_error,
        "loss factor": (fits.loss_factor - mode.loss_factor) / fits.loss_factor_error,
        "constant": np.abs(fits.modal_constant - mode.modal_constant)
        / fits.modal_constant_error
        / np.sqrt(2),
    }
    for name, score in scores.items():
        # 1000 tests give the scatter to 2.2 %; the rest is room for a method less than the best
        assert np.sqrt((score**2).mean()) == pytest.approx(1.0, abs=0.15), name
    assert np.mean(fits.misfit) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("kind", KINDS)
def test_a_batch_gives_what_its_rows_give_alone(kind: str) -> None:
    mode = ModeFit(100.37, 0.01, 1 + 0.2j)
    freq, frf, weight = noisy(np.arange(96.0, 104.0), mode, 0.01, 5, seed=1)
    together = EXTRACTION_METHODS[kind](freq, frf, weight)
    for i in range(5):
        alone = fit_mode(EXTRACTION_METHODS[kind], freq[i], frf[i], weight[i])
        # the same operations on the same numbers, but for the order of sums
        assert together.one(i).frequency == pytest.approx(alone.frequency, rel=1e-12)
        assert together.one(i).modal_constant == pytest.approx(alone.modal_constant, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_lines_without_weight_do_not_count_whatever_they_hold(kind: str) -> None:
    mode = ModeFit(100.37, 0.01, 1 + 0.2j, 1e-6j)
    freq = np.arange(94.0, 107.0)
    frf, weight = mode.response(freq), np.ones(len(freq))
    frf[[0, 5, 12]], weight[[0, 5]] = (np.nan, 1e3, np.inf), 0
    found = fit_mode(EXTRACTION_METHODS[kind], freq, frf, weight)
    kept = np.setdiff1d(np.arange(13), [0, 5, 12])
    alone = fit_mode(EXTRACTION_METHODS[kind], freq[kept], frf[kept])
    # rounding, through a fit of ten lines on another scale
    assert found.loss_factor == pytest.approx(alone.loss_factor, rel=1e-6)
    assert found.modal_constant == pytest.approx(alone.modal_constant, rel=1e-6)
    if EXTRACTION_METHODS[kind].exact:
        assert found.loss_factor == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_what_holds_no_mode_is_refused_and_nothing_is_nan(kind: str) -> None:
    freq = np.arange(80.0, 90.0)
    flank = ModeFit(100.0, 0.01, 1.0).response(freq)
    grows = ModeFit(85.3, -0.01, 1.0).response(freq)
    one_line = np.full(10, np.nan, complex)
    one_line[3] = 1.0
    rows = np.array([flank, grows, np.zeros(10), np.full(10, 3 + 1j), one_line, np.full(10, np.nan)])
    fits = EXTRACTION_METHODS[kind](np.tile(freq, (6, 1)), rows, np.ones((6, 10)))
    assert list(fits.outcome) == [
        Outcome.NO_RESONANCE,
        Outcome.NO_RESONANCE,
        Outcome.NO_SHAPE,
        Outcome.NO_SHAPE,
        Outcome.TOO_FEW_LINES,
        Outcome.TOO_FEW_LINES,
    ]
    for values in (fits.frequency, fits.modal_constant, fits.frequency_error, fits.misfit):
        assert np.isfinite(values).all()
    with pytest.raises(NoModeInBandError, match="80 to 89 Hz"):
        fit_mode(EXTRACTION_METHODS[kind], freq, flank)


@pytest.mark.parametrize("kind", KINDS)
def test_noise_alone_gives_errors_as_large_as_its_values(kind: str) -> None:
    rng = np.random.default_rng(2)
    frf = rng.standard_normal((500, 8)) + 1j * rng.standard_normal((500, 8))
    fits = EXTRACTION_METHODS[kind](np.tile(np.arange(50.0, 58.0), (500, 1)), frf, np.full((500, 8), 0.5))
    clear = fits.found & (np.abs(fits.modal_constant) > 5 * fits.modal_constant_error)
    clear &= fits.loss_factor_error < 0.1 * fits.loss_factor
    # 3 unknowns of 8 lines follow noise now and then; a clear mode with small errors stays rare
    assert clear.mean() < 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_no_rows_give_no_fits(kind: str) -> None:
    fits = EXTRACTION_METHODS[kind](np.empty((0, 8)), np.empty((0, 8), complex), np.empty((0, 8)))
    assert fits.found.shape == (0,)


@pytest.mark.parametrize("kind", KINDS)
def test_every_method_draws_what_it_did_with_the_lines_in_use(kind: str) -> None:
    mode = ModeFit(100.37, 0.03, 1 + 0.2j, 1e-6j)
    freq = np.arange(94.0, 107.0)
    frf, weight = mode.response(freq), np.ones(len(freq))
    frf[0], weight[12] = np.nan, 0
    drawn = EXTRACTION_METHODS[kind].plot(freq, frf, weight)
    np.testing.assert_allclose(drawn["x"], (2 * np.pi * freq[1:12]) ** 2)
    for name, values in drawn.items():
        assert np.isfinite(values).all(), name
        assert values.ndim > 0, name


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_keeps_its_shape_in_other_units(kind: str) -> None:
    freq = np.arange(94.0, 107.0)
    frf = ModeFit(100.37, 0.03, 1 + 0.2j, 1e-6j).response(freq)
    here = EXTRACTION_METHODS[kind].plot(freq, frf, np.ones(13))
    there = EXTRACTION_METHODS[kind].plot(freq, 1e6 * frf, np.ones(13))  # um instead of m
    for name, values in here.items():
        largest = np.abs(values).max()
        ratio = np.abs(there[name]).max() / largest
        # rounding; what is not a length or its inverse stays as it is
        assert min(abs(np.log10(ratio) - power) for power in (-6, 0, 6)) < 1e-9, name
        np.testing.assert_allclose(there[name] / ratio, values, atol=1e-9 * largest, err_msg=name)

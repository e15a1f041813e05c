"""Viscous modes, exact, so heavily damped that the two laws differ."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import Damping
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.method import EXTRACTION_METHODS

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if EXTRACTION_METHODS[kind].exact]
VISCOUS = DAMPING_MODELS[Damping.VISCOUS]
FREQ: FloatArray = np.linspace(80.0, 122.0, 43)
OMEGA = 2 * np.pi * FREQ


def viscous(frequency: float, ratio: float, constant: complex) -> ComplexArray:
    """Receptance of a pair of conjugate poles, as the response to an impulse that decays."""
    omega_r = 2 * np.pi * frequency
    s = omega_r * (-ratio + 1j * np.sqrt(1 - ratio**2))
    residue = constant / (s - s.conjugate())
    return np.asarray(residue / (1j * OMEGA - s) + np.conj(residue) / (1j * OMEGA - s.conjugate()))


def test_of_a_real_mode_the_poles_are_the_equation_of_motion() -> None:
    omega_r, ratio = 2 * np.pi * 100.0, 0.05
    exact = 2.0 / (omega_r**2 - OMEGA**2 + 2j * ratio * omega_r * OMEGA)
    eigenvalue = np.array(omega_r**2 * (1 + 2j * ratio))
    np.testing.assert_allclose(viscous(100.0, ratio, 2.0), exact, rtol=1e-12)  # rounding
    np.testing.assert_allclose(VISCOUS.response(FREQ, eigenvalue, np.array(2.0 + 0j)), exact, rtol=1e-12)


@pytest.mark.parametrize("kind", EXACT)
@pytest.mark.parametrize("constant", [1.0, 1.0 + 0.3j])
@pytest.mark.parametrize("order", [0, 2])
def test_a_viscous_mode_of_five_per_cent_is_exact(order: int, constant: complex, kind: str) -> None:
    frf = viscous(100.3, 0.05, constant) * (1j * OMEGA) ** order
    frf = frf + (1e-6 - 5e-7j) * (2 * np.pi * 100.3) ** order
    fits = VISCOUS.fit(
        EXTRACTION_METHODS[kind], FREQ[None], frf[None], np.ones((1, len(FREQ))), np.array([order])
    )
    assert fits.frequency[0] == pytest.approx(100.3, rel=1e-6)
    # the mirror image taken off by the fit before: what is left after four rounds
    assert fits.loss_factor[0] == pytest.approx(0.1, rel=1e-5)
    squared, _ = VISCOUS.pole(np.array((2 * np.pi * 100.3) ** 2 * (1 + 0.1j)), np.array(1 + 0j))
    expected = constant * (-squared) ** (order // 2)
    assert fits.modal_constant[0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("kind", EXACT)
def test_the_other_law_misses_such_a_mode_and_its_misfit_shows_it(kind: str) -> None:
    frf, weight = viscous(100.3, 0.05, 1.0)[None], np.ones((1, len(FREQ)))
    right = VISCOUS.fit(EXTRACTION_METHODS[kind], FREQ[None], frf, weight, np.array([0]))
    wrong = DAMPING_MODELS[Damping.STRUCTURAL].fit(
        EXTRACTION_METHODS[kind], FREQ[None], frf, weight, np.array([0])
    )
    # damping of 2 zeta omega omega_r instead of constant: its slope turns into a phase of the constant
    assert abs(np.angle(wrong.modal_constant[0])) > 0.05
    assert abs(np.angle(right.modal_constant[0])) < 1e-4
    assert wrong.misfit[0] > 100 * right.misfit[0]


@pytest.mark.parametrize("kind", EXACT)
def test_standard_errors_of_viscous_modes_are_the_scatter_of_repeated_tests(kind: str) -> None:
    rng = np.random.default_rng(4)
    clean = np.broadcast_to(viscous(100.3, 0.05, 1.0), (400, len(FREQ)))
    size = 0.01 * np.abs(clean)
    error = rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape)
    frf = clean + size / np.sqrt(2) * error
    freq = np.broadcast_to(FREQ, clean.shape)
    fits = VISCOUS.fit(EXTRACTION_METHODS[kind], freq, frf, 1 / size**2, np.zeros(400, int))
    scores = {
        "frequency": (fits.frequency - 100.3) / fits.frequency_error,
        "loss factor": (fits.loss_factor - 0.1) / fits.loss_factor_error,
    }
    for name, score in scores.items():
        # 400 tests give the scatter to 3.5 %; the rest is room for a method less than the best
        assert np.sqrt((score**2).mean()) == pytest.approx(1.0, abs=0.2), name


@pytest.mark.parametrize("kind", sorted(EXTRACTION_METHODS))
def test_what_is_no_mode_is_none_under_either_law(kind: str) -> None:
    flank = viscous(150.0, 0.01, 1.0)
    grows = viscous(100.0, -0.01, 1.0)
    rows = np.array([flank, grows, np.zeros_like(flank)])
    freq, weight = np.tile(FREQ, (3, 1)), np.ones((3, len(FREQ)))
    fits = VISCOUS.fit(EXTRACTION_METHODS[kind], freq, rows, weight, np.zeros(3, int))
    assert not fits.found.any()
    assert np.isfinite(fits.modal_constant).all()
    assert not fits.frequency.any()


def test_a_picked_peak_of_mobility_is_as_good_under_either_law() -> None:
    frf = (1j * OMEGA * viscous(100.0, 0.05, 1.0))[None]
    fits = VISCOUS.fit(
        EXTRACTION_METHODS["peak_picking"], FREQ[None], frf, np.ones((1, len(FREQ))), np.array([1])
    )
    assert fits.frequency[0] == pytest.approx(100.0, rel=0.005)  # half a line
    assert fits.loss_factor[0] == pytest.approx(0.1, rel=0.03)  # chords between lines, 10 a bandwidth

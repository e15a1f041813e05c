import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.preprocessing.indicators import complex_mode_indicator, real_part_indicator
from tests.service.extraction.conftest import Beam

FREQ = np.linspace(10.0, 60.0, 2001)
DOFS = tuple(Dof(node, "Y") for node in range(1, 5))
SHAPES = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0]]).T


def frfs(poles: FloatArray, n_in: int, kind: FrfKind = FrfKind.RECEPTANCE, eta: float = 0.01) -> FrfSet:
    """Return responses of orthogonal real modes with these frequencies, Hz."""
    gap = (2 * np.pi * poles) ** 2 * (1 + 1j * eta) - ((2 * np.pi * FREQ) ** 2)[:, None]
    values = np.einsum("jr,fr,kr->fjk", SHAPES[:, : len(poles)], 1 / gap, SHAPES[:n_in, : len(poles)])
    return FrfSet(FREQ, values, DOFS, DOFS[:n_in], FrfKind.RECEPTANCE).to(kind)


def dips(values: FloatArray) -> FloatArray:
    inner = values[1:-1]
    low = (inner < values[:-2]) & (inner < values[2:]) & (inner < 0.2)
    return FREQ[1:-1][low]


@pytest.mark.parametrize("kind", FrfKind)
def test_the_mode_indicator_dips_at_every_resonance_whatever_the_kind(kind: FrfKind) -> None:
    poles = np.array([20.0, 30.0, 45.0])
    found = real_part_indicator(frfs(poles, 2, kind))
    assert found.shape == (2001, 2)
    assert (found >= 0).all()
    assert (found <= 1).all()
    for column in found.T:
        # of 0.2 to 0.5 Hz wide modes on lines of 0.025 Hz: the others' tails are real and move it a little
        np.testing.assert_allclose(dips(column), poles, atol=0.05)


def test_a_single_mode_has_the_closed_form_of_its_receptance() -> None:
    found = real_part_indicator(frfs(np.array([30.0]), 1, eta=0.05))[:, 0]
    # Re/|.| of 1/(1 - x + i eta), x = (f/f_r)^2
    away = 1 - (FREQ / 30.0) ** 2
    np.testing.assert_allclose(found, np.abs(away) / np.hypot(away, 0.05), atol=1e-12)  # rounding


def test_a_mode_that_moves_a_twentieth_dips_too() -> None:
    frf = frfs(np.array([20.0, 40.0]), 1)
    both = frf.values.copy()
    small = frfs(np.array([20.0]), 1).values
    both = 0.05 * small + (both - small)
    found = real_part_indicator(FrfSet(FREQ, both, DOFS, DOFS[:1], FrfKind.RECEPTANCE))[:, 0]
    # the peak is fifteen times the other mode's tail, which is real
    np.testing.assert_allclose(dips(found), [20.0, 40.0], atol=0.05)


def test_two_modes_at_one_frequency_are_two_singular_values() -> None:
    found = complex_mode_indicator(frfs(np.array([30.0, 30.0]), 2))
    at = int(np.argmin(np.abs(FREQ - 30.0)))
    assert found.shape == (2001, 2)
    # four unit components answer two: |phi_out| |phi_in| = 2 sqrt(2) of each mode over i eta omega_r^2
    np.testing.assert_allclose(found[at], 2 * np.sqrt(2) / (0.01 * (60 * np.pi) ** 2), rtol=1e-6)
    single = complex_mode_indicator(frfs(np.array([30.0]), 2))
    assert single[:, 1].max() < 1e-12 * single[:, 0].max()  # rounding


def test_one_force_has_one_singular_value_the_root_of_the_power(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    found = complex_mode_indicator(frf)
    assert found.shape == (401, 1)
    np.testing.assert_allclose(found[:, 0], np.linalg.norm(frf.values[:, :, 0], axis=1), rtol=1e-12)


def test_the_modes_of_a_beam_are_peaks_and_dips(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq).between(0, 800)
    dip, peak = real_part_indicator(frf)[:, 0], complex_mode_indicator(frf.to(FrfKind.MOBILITY))[:, 0]
    for frequency in plain_beam.frequencies[1:, 0]:  # mode 1 lies between two lines ten times its width apart
        near = np.flatnonzero(np.abs(frf.freq - frequency) < 12)
        assert abs(frf.freq[near[np.argmin(dip[near])]] - frequency) <= 2.0  # a line
        assert abs(frf.freq[near[np.argmax(peak[near])]] - frequency) <= 2.0


def test_lines_where_nothing_moves_show_nothing() -> None:
    still = FrfSet(np.array([1.0, 2.0]), np.zeros((2, 4, 1), complex), DOFS, DOFS[:1], FrfKind.INERTANCE)
    np.testing.assert_array_equal(real_part_indicator(still), 1.0)
    np.testing.assert_array_equal(complex_mode_indicator(still), 0.0)

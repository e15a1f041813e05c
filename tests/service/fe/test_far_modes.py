"""Sums over modes far above a band."""

import numpy as np
import pytest

from modallab.fe.far_modes import FarModes, are_far
from modallab.fe.modes import ModalBasis

OMEGA = np.linspace(1.0, 1000.0, 201)


@pytest.mark.parametrize("loss_factor", [0.0, 0.01, 0.5])
def test_a_series_is_the_sum_over_far_modes(loss_factor: float) -> None:
    rng = np.random.default_rng(1)
    frequencies = np.geomspace(2.001, 1e3, 60) * OMEGA[-1]
    eigenvalues = np.asarray(frequencies**2 * (1 + 1j * loss_factor), complex)
    constants = rng.standard_normal((5, 60))
    exact = constants @ (1 / (eigenvalues[:, None] - OMEGA**2))
    alpha = np.zeros(exact.shape, complex)
    FarModes(eigenvalues, OMEGA).add_to(alpha, constants)
    # Rounding of a sum of 60 terms, over the size of its largest one.
    assert np.abs(alpha - exact).max() < 1e-14 * np.abs(constants).max() / np.abs(eigenvalues).min() * 60


def test_modes_are_far_above_twice_the_highest_frequency() -> None:
    eigenvalues = (np.array([0.0, 500.0, *np.linspace(1990.0, 2010.0, 2), *np.full(40, 5000.0)]) + 0j) ** 2
    far = are_far(eigenvalues, OMEGA)
    assert far.tolist() == [False] * 3 + [True] * 41


def test_few_modes_are_summed_one_by_one() -> None:
    assert not are_far(np.full(20, 1e8 + 0j), OMEGA).any()


def test_no_mode_is_far_from_complex_frequencies() -> None:
    assert not are_far(np.full(40, 1e8 + 0j), np.asarray(OMEGA - 1j, complex)).any()


def test_a_receptance_has_near_and_far_modes_in_any_order() -> None:
    rng = np.random.default_rng(2)
    frequencies = rng.permutation(np.concatenate([np.linspace(0.1, 1.9, 10), np.geomspace(2.1, 50.0, 40)]))
    eigenvalues = np.asarray((frequencies * OMEGA[-1]) ** 2 * (1 + 0.01j), complex)
    shapes, motions = rng.standard_normal((6, 50)), np.eye(6)
    exact = np.einsum("im,jm,fm->fij", shapes, shapes, 1 / (eigenvalues - OMEGA[:, None] ** 2))
    alpha = ModalBasis(eigenvalues, shapes, 0).at(OMEGA).receptance(motions, motions)
    # Rounding of sums of 50 terms, over the largest of them.
    assert np.abs(alpha - exact).max() < 1e-14 * np.abs(exact).max() * 50

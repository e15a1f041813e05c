import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.estimation.multiple_coherence import coherence_per_force
from modallab.extraction.preprocessing.responses import responses_of


def test_of_one_force_it_is_the_coherence_itself() -> None:
    coherence = np.linspace(0, 1, 5)[:, None]
    np.testing.assert_array_equal(
        coherence_per_force(np.ones((5, 1, 1), complex), coherence)[:, :, 0], coherence
    )


def test_noise_counts_against_the_part_of_each_force() -> None:
    values = np.array([[[3.0, 4.0j]]])
    each = coherence_per_force(values, np.array([[0.9]]))[0, 0]
    # noise is a ninth of 25: against 9, and against 16
    np.testing.assert_allclose((1 - each) / each, [25 / 9 / 9, 25 / 9 / 16])
    np.testing.assert_allclose(coherence_per_force(values, np.ones((1, 1))), 1.0, rtol=1e-15)  # rounding
    np.testing.assert_array_equal(coherence_per_force(0 * values, np.array([[0.5]])), 0.0)


def test_random_errors_from_it_are_those_of_drawn_spectra() -> None:
    """H1 of two independent white forces and a response with noise, many times over."""
    rng = np.random.default_rng(5)
    n_tests, averages, truth = 400, 50, np.array([1.0, 0.2j])

    def circular(*shape: int) -> np.ndarray:
        return np.asarray((rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2))

    force, noise = circular(n_tests, averages, 2), 0.3 * circular(n_tests, averages)
    response = force @ truth + noise
    ff = np.einsum("tai,taj->tij", force.conj(), force)
    fx = np.einsum("tai,ta->ti", force.conj(), response)
    found = np.linalg.solve(ff, fx[..., None])[..., 0]
    coherent = (found.conj() * fx).sum(axis=1).real / (np.abs(response) ** 2).sum(axis=1)
    dofs = (Dof(1, "Y"), Dof(2, "Y"))
    frf = FrfSet(np.linspace(1.0, 2.0, n_tests), found[:, None], dofs[:1], dofs, FrfKind.RECEPTANCE)
    variance = responses_of(frf, coherent[:, None], averages).variance
    scatter = (np.abs(found - truth) ** 2).mean(axis=0)
    # 400 tests tell a variance to 5 %, and that of 50 averages lacks some 4 % for two forces
    np.testing.assert_allclose(np.median(variance, axis=0), scatter, rtol=0.2)
    assert scatter[0] == pytest.approx(scatter[1], rel=0.2), "the noise is of the response"

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.estimation.partial_coherence import partial_coherence
from modallab.extraction.preprocessing.responses import responses_of


def test_of_one_force_it_is_the_coherence_itself() -> None:
    coherence = np.linspace(0, 1, 5)[:, None]
    np.testing.assert_array_equal(
        partial_coherence(np.ones((5, 1, 1), complex), coherence)[:, :, 0], coherence
    )


def test_noise_counts_against_the_part_of_each_force() -> None:
    values = np.array([[[3.0, 4.0j]]])
    each = partial_coherence(values, np.array([[0.9]]))[0, 0]
    # noise is a ninth of 25: against 9, and against 16
    np.testing.assert_allclose((1 - each) / each, [25 / 9 / 9, 25 / 9 / 16])
    np.testing.assert_allclose(partial_coherence(values, np.ones((1, 1))), 1.0, rtol=1e-15)  # rounding
    np.testing.assert_array_equal(partial_coherence(0 * values, np.array([[0.5]])), 0.0)


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


def test_of_correlated_forces_each_counts_with_what_the_other_does_not_explain() -> None:
    """The matrix form against the definition: residuals of both after the other force is taken out."""
    h, tied, noise = np.array([2.0, 1.0 - 1.0j]), 0.6 + 0.3j, 0.5
    forces = np.array([[3.0, tied], [np.conj(tied), 2.0]])  # E[conj(F_j) F_k]
    coherent = (h.conj() @ forces @ h).real
    multiple = np.array([[coherent / (coherent + noise)]])
    found = partial_coherence(h[None, None], multiple, forces[None, None])[0, 0]
    for k, other in ((0, 1), (1, 0)):
        alone = forces[k, k].real - abs(tied) ** 2 / forces[other, other].real
        explained = abs(h[k]) ** 2 * alone
        assert found[k] == pytest.approx(explained / (explained + noise), rel=1e-12)  # rounding


def test_the_error_from_it_is_that_of_frfs_to_correlated_forces() -> None:
    """H1 of two forces that follow each other in part, many times over."""
    rng = np.random.default_rng(6)
    n_tests, averages, truth = 4000, 12, np.array([1.0, 0.5j])

    def circular(*shape: int) -> np.ndarray:
        return np.asarray((rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2))

    force = circular(n_tests, averages, 2)
    force[..., 1] = 0.8 * force[..., 0] + 0.6 * force[..., 1]
    response = force @ truth + 0.3 * circular(n_tests, averages)
    ff = np.einsum("tai,taj->tij", force.conj(), force)
    fx = np.einsum("tai,ta->ti", force.conj(), response)
    h = np.linalg.solve(ff, fx[..., None])[..., 0]
    multiple = (h.conj() * fx).sum(axis=1).real / (np.abs(response) ** 2).sum(axis=1)
    g2 = partial_coherence(h[:, None], multiple[:, None], ff[:, None])[:, 0]
    # A complex t distribution: the squared error over its estimate has a mean of 1 with n - n_in - 1.
    squares = np.abs(h - truth) ** 2 / (np.abs(h) ** 2 * (1 - g2) / g2 / (averages - 2 - 1))
    # 4000 tests tell the mean of an F distribution of 2 and 20 degrees of freedom to 2 %: three errors
    np.testing.assert_allclose(squares.mean(axis=0), 1.0, atol=0.06)


def test_a_force_that_follows_from_the_other_tells_nothing_alone() -> None:
    values, multiple = np.ones((1, 1, 2), complex), np.array([[0.9]])
    np.testing.assert_array_equal(partial_coherence(values, multiple, np.ones((1, 1, 2, 2), complex)), 0.0)
    idle = np.diag([1.0, 0.0])[None, None] + 0j
    assert (partial_coherence(values, multiple, idle)[0, 0] > 0).tolist() == [True, False]

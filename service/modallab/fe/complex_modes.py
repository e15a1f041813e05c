"""Modes that structural damping couples."""

import numpy as np
from scipy.linalg import eig
from scipy.sparse.csgraph import connected_components

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.settings import DAMPED_MODES


def damped_modes(squares: FloatArray, modal: FloatArray) -> tuple[ComplexArray, ComplexArray | None]:
    """Return eigenvalues with structural damping Phi^T D Phi, and the modes in terms of the undamped
    ones where damping couples them."""
    loss = np.diag(modal)
    size = np.abs(loss)  # a rigid-body mode's may be a rounding error below zero
    threshold = np.maximum(
        DAMPED_MODES.relative_coupling * np.sqrt(np.outer(size, size)),
        PRODUCT_ROUNDING * size.max(initial=0.0),
    )
    n_groups, group = connected_components(np.abs(modal - np.diag(loss)) > threshold, directed=False)
    values = squares + 1j * loss
    if n_groups == len(values):
        return values, None
    # Group by group: solved for together, modes that damping leaves alone, above all rigid-body
    # modes of one and the same eigenvalue, would come back mixed and no longer orthogonal.
    rotation = np.eye(len(values), dtype=complex)
    for members in (np.flatnonzero(group == g) for g in range(n_groups)):
        if len(members) > 1:
            block = np.ix_(members, members)
            values[members], rotation[block] = _coupled_group(squares[members], modal[block])
    order = np.argsort(values.real, kind="stable")
    return values[order], rotation[:, order]


def _coupled_group(squares: FloatArray, modal: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return eigenvalues and vectors, v^T v = 1, of undamped modes with the damping between them.

    The eigen-solution is off by rounding of the highest eigenvalue, which is more than what rigid-body
    modes differ by: their vectors come back at any angle to one another. Newton's iteration for the
    nearest orthogonal ones, Higham, Functions of Matrices (2008), 8.3, mixes none that differ by more.
    """
    matrix = np.diag(squares) + 1j * modal
    vectors = eig(matrix)[1]
    vectors = vectors / np.sqrt((vectors**2).sum(axis=0))
    departure = np.inf
    while departure > DAMPED_MODES.orthogonality_tolerance:
        error = vectors.T @ vectors - np.eye(len(squares))
        previous, departure = departure, float(np.abs(error).max())
        if not departure < previous:  # vectors that all but fall together, as where damping is critical
            break
        vectors = vectors - vectors @ error / 2
    values = (vectors * (matrix @ vectors)).sum(axis=0)
    largest = vectors[np.abs(vectors).argmax(axis=0), np.arange(len(values))]
    return values, vectors * np.where(largest.real < 0, -1.0, 1.0)

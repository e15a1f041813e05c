"""Complex modes of structural damping that couples undamped modes."""

import numpy as np
from scipy.linalg import eig
from scipy.sparse.csgraph import connected_components

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.settings import DAMPED_MODES


def damped_modes(squares: FloatArray, modal: FloatArray) -> tuple[ComplexArray, ComplexArray | None]:
    """Return eigenvalues with structural damping, and the transformation of the undamped modes.

    The transformation is None where the modal damping matrix Phi^T D Phi is diagonal.
    """
    loss = np.diag(modal)
    size = np.abs(loss)  # that of a rigid-body mode may be negative by rounding
    threshold = np.maximum(
        DAMPED_MODES.relative_coupling * np.sqrt(np.outer(size, size)),
        PRODUCT_ROUNDING * size.max(initial=0.0),
    )
    n_groups, group = connected_components(np.abs(modal - np.diag(loss)) > threshold, directed=False)
    values = squares + 1j * loss
    if n_groups == len(values):
        return values, None
    # Group by group: a common solution would mix uncoupled modes of equal eigenvalue, above all
    # rigid-body modes, and return vectors that are not orthogonal.
    rotation = np.eye(len(values), dtype=complex)
    for members in (np.flatnonzero(group == g) for g in range(n_groups)):
        if len(members) > 1:
            block = np.ix_(members, members)
            values[members], rotation[block] = _coupled_group(squares[members], modal[block])
    order = np.argsort(values.real, kind="stable")
    return values[order], rotation[:, order]


def _coupled_group(squares: FloatArray, modal: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return eigenvalues and vectors, v^T v = 1, of undamped modes with the damping between them.

    The error of the eigensolution is rounding of the highest eigenvalue, larger than the differences
    between eigenvalues of rigid-body modes: their vectors are not orthogonal. Newton's iteration for the
    nearest orthogonal vectors, Higham, Functions of Matrices (2008), 8.3, does not mix the others.
    """
    matrix = np.diag(squares) + 1j * modal
    vectors = eig(matrix)[1]
    vectors = vectors / np.sqrt((vectors**2).sum(axis=0))
    departure = np.inf
    while departure > DAMPED_MODES.orthogonality_tolerance:
        error = vectors.T @ vectors - np.eye(len(squares))
        previous, departure = departure, float(np.abs(error).max())
        if not departure < previous:  # nearly parallel vectors, as at critical damping
            break
        vectors = vectors - vectors @ error / 2
    values = (vectors * (matrix @ vectors)).sum(axis=0)
    largest = vectors[np.abs(vectors).argmax(axis=0), np.arange(len(values))]
    return values, vectors * np.where(largest.real < 0, -1.0, 1.0)

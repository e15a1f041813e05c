"""Error matrix method: errors of stiffness and mass by flexibility."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import UnderdeterminedError
from modallab.correlation.settings import PAIRING
from modallab.updating.direct.method import (
    DIRECT_METHODS,
    DirectProblem,
    ErrorLocation,
    RegisteredDirectMethod,
    diagonal_scaling,
    relative_row_norms,
)


def error_matrix(problem: DirectProblem) -> ErrorLocation:
    """First-order errors of stiffness and mass, as far as the measured modes show them.

    dK = K (F_a - F_x) K with F = Phi Lambda^-1 Phi^T of model and measured modes in pairs, and dM = M (Phi_a
    Phi_a^T - Phi_x Phi_x^T) M, 1992 thesis, equations 2.26, 2.27. With all modes this is correct to first
    order. With few modes each row is divided by the row that the same modes give for the model's own matrix,
    because stiff DoFs would otherwise hide wrong ones. Mass errors need many more modes than stiffness
    errors: low modes determine the flexibility, but not the inverse of the mass. Sidhu, J. and Ewins, D. J.
    (1984), Proc. 2nd International Modal Analysis Conference.

    Raises
    ------
    UnderdeterminedError
        If a measured mode pairs with none of the model.
    """
    model_shapes, model_squares = (
        problem.model_shapes[:, problem.partners],
        problem.model_squares[problem.partners],
    )
    _check_pairs(problem, model_shapes)
    stiffness, model_stiffness = _error(
        problem.stiffness, model_shapes / np.sqrt(model_squares), problem.shapes / np.sqrt(problem.squares)
    )
    mass, model_mass = _error(problem.mass, model_shapes, problem.shapes)
    return ErrorLocation(
        {"mass": mass, "stiffness": stiffness},
        {
            "mass": relative_row_norms(mass, model_mass, diagonal_scaling(problem.mass)),
            "stiffness": relative_row_norms(stiffness, model_stiffness, diagonal_scaling(problem.stiffness)),
        },
    )


def _check_pairs(problem: DirectProblem, model_shapes: FloatArray) -> None:
    """Raise `UnderdeterminedError` if a measured mode lies outside the space of its paired model modes.

    All pairs count together, as close modes may be rotated among one another.
    """
    inertia_shapes = problem.mass @ problem.shapes
    sizes = np.einsum("ir,ir->r", problem.shapes, inertia_shapes)
    share = ((model_shapes.T @ inertia_shapes) ** 2).sum(axis=0) / sizes
    worst = int(share.argmin())
    if share[worst] < PAIRING.min_mac:
        raise UnderdeterminedError(
            f"measured mode {worst + 1} pairs with no mode of the model",
            field="modes",
            value=worst + 1,
            allowed=f"{PAIRING.min_mac:.0%} or more of its motion in modes of the model",
        )


def _error(
    matrix: FloatArray, model_shapes: FloatArray, measured: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return A (F_a F_a^T - F_x F_x^T) A, and A F_a F_a^T A by the model's modes alone, (n, n) each."""
    model_part, measured_part = matrix @ model_shapes, matrix @ measured
    model_matrix = model_part @ model_part.T
    return model_matrix - measured_part @ measured_part.T, model_matrix


DIRECT_METHODS.register("error_matrix")(RegisteredDirectMethod(error_matrix))

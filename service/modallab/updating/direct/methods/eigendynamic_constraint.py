"""Eigendynamic constraint method: coefficients of all members from the equation of motion."""

import numpy as np
from scipy.linalg import eigvalsh

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, UnderdeterminedError
from modallab.updating.direct.method import (
    DIRECT_METHODS,
    EXPANSION,
    Correction,
    DirectProblem,
    Elements,
    RegisteredDirectMethod,
    diagonal_scaling,
)


def eigendynamic_constraint(problem: DirectProblem) -> Correction:
    """Mass and stiffness of every member such that measured modes fulfil its equation of motion.

    sum b_i K_i phi_r = lambda_r sum a_i M_i phi_r and phi_r^T sum a_i M_i phi_r = 1 of all modes, by SVD;
    parts that belong to no member do not change, and the connections are kept. With exact shapes at all
    degrees of freedom the result is exact, and one mode is enough. Errors of shapes are errors of the
    coefficients of these equations: with an error of 1e-4 in every entry, results for a beam are wrong by
    half, and expanded shapes are no better. 1992 thesis, equations 2.11 to 2.14.

    Raises
    ------
    InvalidInputError
        If the model was reduced, or has no members.
    UnderdeterminedError
        If the modes do not determine all coefficients, or give a mass matrix that is not positive definite.
    """
    elements = _elements(problem)
    n_members = len(elements.numbers)
    equations, missing = _equations(problem, elements)
    change, _, rank, _ = np.linalg.lstsq(equations, missing, rcond=None)
    if rank < 2 * n_members:
        raise UnderdeterminedError(
            f"{len(problem.squares)} modes tell {rank} of {2 * n_members} coefficients apart",
            field="n_modes",
            value=len(problem.squares),
            allowed="modes that move and strain every member",
        )
    added = change[:, None, None]
    n = len(problem.dofs)
    mass = problem.mass + elements.sum(added[:n_members] * elements.mass, n)
    stiffness = problem.stiffness + elements.sum(added[n_members:] * elements.stiffness, n)
    coefficients = {
        part: dict(zip(elements.numbers, (1 + part_change).tolist(), strict=True))
        for part, part_change in zip(("mass", "stiffness"), np.split(change, 2), strict=True)
    }
    _check_mass(mass, coefficients["mass"])
    return Correction(mass, stiffness, coefficients=coefficients)


def _elements(problem: DirectProblem) -> Elements:
    if problem.elements is None:
        raise InvalidInputError(
            "coefficients of members need the model's own degrees of freedom, and members",
            field="completion",
            value="a reduced model, or matrices alone",
            allowed=EXPANSION,
        )
    return problem.elements


def _equations(problem: DirectProblem, elements: Elements) -> tuple[FloatArray, FloatArray]:
    """Return A (n m + m, 2 n_members) and r of A d = r, d the changes of mass and then of stiffness.

    Forces are in units of their DoFs and of the mode, sqrt(K_ii) omega_r: every row is a plain number.
    """
    phi, squares = problem.shapes, problem.squares
    unit = diagonal_scaling(problem.stiffness)[:, None] / np.sqrt(squares)
    inertia, strain = elements.times(elements.mass, phi), elements.times(elements.stiffness, phi)
    forces = np.concatenate([-inertia * squares, strain]) * unit
    own_mass = np.einsum("ir,eir->er", phi, inertia)
    sizes = np.concatenate([own_mass, np.zeros_like(own_mass)])
    force_imbalance = (problem.stiffness @ phi - problem.mass @ phi * squares) * unit
    modal_mass_deficit = 1 - np.einsum("ir,ir->r", phi, problem.mass @ phi)
    equations = np.hstack([forces.reshape(len(forces), -1), sizes]).T
    return equations, np.concatenate([-force_imbalance.ravel(), modal_mass_deficit])


def _check_mass(mass: FloatArray, coefficients: dict[int, float]) -> None:
    if eigvalsh(mass, subset_by_index=[0, 0])[0] > 0:
        return
    worst = min(coefficients, key=coefficients.__getitem__)
    raise UnderdeterminedError(
        f"no structure has these modes: member {worst} would have {coefficients[worst]:.2g} times its mass",
        field="modes",
        value=worst,
        allowed="shapes near enough to those of a structure of these members",
    )


DIRECT_METHODS.register("eigendynamic_constraint")(RegisteredDirectMethod(eigendynamic_constraint))

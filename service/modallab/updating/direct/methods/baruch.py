"""Baruch's method: stiffness corrected on the model's own mass."""

from modallab.updating.direct.constrained import constrained_stiffness, mass_orthonormal
from modallab.updating.direct.method import DIRECT_METHODS, Correction, DirectProblem, RegisteredDirectMethod


def baruch(problem: DirectProblem) -> Correction:
    """Stiffness nearest to the model's that has the measured modes; the mass is taken to be right.

    Shapes are first made orthonormal in the model's mass, Phi <- Phi (Phi^T M Phi)^(-1/2), as near to the
    measured ones as can be: without it no symmetric stiffness has them. Nearest in the norm of
    M^(-1/2) dK M^(-1/2). Connections that the structure lacks appear, and modes beyond those measured move
    as they may. Baruch, M. (1978), AIAA Journal 16(11), 1208-1210.

    Raises
    ------
    UnderdeterminedError
        If the measured shapes are not independent of one another.
    """
    shapes = mass_orthonormal(problem.shapes, problem.mass)
    stiffness = constrained_stiffness(problem.stiffness, problem.mass, shapes, problem.squares)
    return Correction(problem.mass, stiffness, changed=("stiffness",))


DIRECT_METHODS.register("baruch")(RegisteredDirectMethod(baruch))

"""Berman and Nagy's method: mass corrected first, then stiffness."""

import numpy as np

from modallab.updating.direct.constrained import constrained_stiffness, modal_mass
from modallab.updating.direct.method import DIRECT_METHODS, Correction, DirectProblem, RegisteredDirectMethod


def berman_nagy(problem: DirectProblem) -> Correction:
    """Mass nearest to the model's in which measured shapes are orthonormal, then a stiffness with the modes.

    M_u = M + M Phi m^-1 (1 - m) m^-1 Phi^T M with m = Phi^T M Phi, then the stiffness step in M_u. Measured
    modes are had exactly; connections that the structure lacks appear, and modes beyond those measured
    move as they may. Berman, A. and Nagy, E. J. (1983), AIAA Journal 21(8), 1168-1173.

    Raises
    ------
    UnderdeterminedError
        If the measured shapes are not independent of one another.
    """
    small = modal_mass(problem.shapes, problem.mass)
    lifted = np.linalg.solve(small, problem.shapes.T @ problem.mass)  # m^-1 Phi^T M
    mass = problem.mass + lifted.T @ (np.eye(len(small)) - small) @ lifted
    mass = (mass + mass.T) / 2  # symmetric but for rounding
    return Correction(mass, constrained_stiffness(problem.stiffness, mass, problem.shapes, problem.squares))


DIRECT_METHODS.register("berman_nagy")(RegisteredDirectMethod(berman_nagy))

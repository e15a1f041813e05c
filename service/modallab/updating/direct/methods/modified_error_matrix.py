"""Modified error matrix method: force residual of measured modes in the model."""

import numpy as np

from modallab.updating.direct.method import (
    DIRECT_METHODS,
    DirectProblem,
    ErrorLocation,
    RegisteredDirectMethod,
)


def modified_error_matrix(problem: DirectProblem) -> ErrorLocation:
    """Rows of the force balance that are not zero: DoFs where mass or stiffness is wrong.

    dK Phi Phi^T - dM Phi Lambda Phi^T = M Phi Lambda Phi^T - K Phi Phi^T [2.29], without any assumption that
    errors are small, and from a single mode on. The method does not show which of the two matrices is wrong.
    The error of a DoF is the force that remains there over the inertia and elastic forces, 0 to 1, and
    therefore independent of units and of stiff DoFs. Errors of an expansion of shapes also cause a force that
    remains. Fisette, E., Stavrinidis, C. and Ibrahim, S. (1988), Proc. 6th International Modal Analysis
    Conference.
    """
    inertia = problem.mass @ problem.shapes * problem.squares
    elastic = problem.stiffness @ problem.shapes
    imbalance = inertia - elastic
    # Forces of a mode grow with omega^2, its energy does not.
    mode_scale = 1 / np.sqrt(problem.squares)
    sizes = [np.linalg.norm(force * mode_scale, axis=1) for force in (imbalance, inertia, elastic)]
    force_sum = sizes[1] + sizes[2]
    share = np.divide(sizes[0], force_sum, out=np.zeros_like(force_sum), where=force_sum > 0)
    return ErrorLocation(
        {"force_balance": imbalance @ problem.shapes.T}, {"force_balance": np.asarray(share)}
    )


DIRECT_METHODS.register("modified_error_matrix")(RegisteredDirectMethod(modified_error_matrix))

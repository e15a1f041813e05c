"""Damping that is known mode by mode, as an attachment."""

import numpy as np

from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem


def modal_damping(system: DynamicSystem, loss_factors: tuple[float, ...]) -> Attachment:
    """Return the structural damping that gives the elastic modes these loss factors in rising order.

    The last one holds for every mode above. D = M Phi diag(eta_r lambda_r) Phi^T M, which leaves the
    modes as they are.
    """
    basis = system.base_modes(frequency_max=1e3).elastic()
    squares = basis.eigenvalues.real
    etas = np.full(len(squares), loss_factors[-1])
    etas[: len(loss_factors)] = loss_factors[: len(squares)]
    return Attachment(system.mass @ basis.shapes.real, damping=np.diag(etas * squares))

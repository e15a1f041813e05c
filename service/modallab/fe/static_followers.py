"""Static transformation of master to slave degrees of freedom (Guyan reduction)."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.partition import Partition, StaticSolver


def static_followers(split: Partition, solve: StaticSolver) -> FloatArray:
    """Return -K_ss^-1 K_sm, (n_slave, n_master).

    Parameters
    ----------
    solve
        `split.static()`.
    """
    return -solve(split.system.stiffness[np.ix_(split.slaves, split.rows)].toarray())

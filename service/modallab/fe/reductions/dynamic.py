"""Reduction at a frequency."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import parameter
from modallab.fe.partition import Partition
from modallab.fe.reduction import REDUCTIONS, Reduction


@REDUCTIONS.register("dynamic")
@dataclass(frozen=True)
class Dynamic(Reduction):
    """Dynamic reduction at one frequency: x_s = -(K_ss - w^2 M_ss)^-1 (K_sm - w^2 M_sm) x_m.

    Exact at that frequency, also for a mode that lies there; at 0 Hz it is the static one. Expansion
    takes each mode's own frequency where none is given. Leung, A. Y. T. (1978), International Journal for
    Numerical Methods in Engineering 12(11), 1705-1715; Kidder, R. L. (1973), AIAA Journal 11(6), 892.
    """

    kind = "dynamic"
    summary = "slaves follow as at one frequency: exact there"
    frequency: float = parameter(
        0.0, unit="Hz", lower=0.0, upper=1e6, doc="where it is exact; 0 when expanding: each mode's own"
    )

    def transformation(self, split: Partition) -> FloatArray:
        """Return T, (n, n_master)."""
        omega = 2 * np.pi * self.frequency
        solve = split.dynamic(omega) if omega else split.static()
        block = np.ix_(split.slaves, split.rows)
        return split.with_masters(
            -solve((split.system.stiffness[block] - omega**2 * split.system.mass[block]).toarray())
        )

    def at_mode(self, frequency: float) -> Self:
        """Return the reduction at a mode's frequency, Hz, unless it has one of its own."""
        return self if self.frequency else replace(self, frequency=frequency)

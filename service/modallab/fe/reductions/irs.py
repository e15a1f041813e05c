"""The improved reduced system."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.parameters import parameter
from modallab.fe.partition import Partition
from modallab.fe.reduction import REDUCTIONS, Reduction
from modallab.fe.static_followers import static_followers


@REDUCTIONS.register("irs")
@dataclass(frozen=True)
class Irs(Reduction):
    """Static reduction corrected by the inertia forces of the slaves.

    t_(i+1) = t_G + K_ss^-1 (M_sm + M_ss t_i) M_R,i^-1 K_R,i, with t_G static. One step is the improved
    reduced system of O'Callahan, J. (1989), Proc. 7th International Modal Analysis Conference, 17-21;
    more converge to the lowest modes: Friswell, M. I., Garvey, S. D. and Penny, J. E. T. (1995), Journal of
    Sound and Vibration 186(2), 311-323.
    """

    kind = "irs"
    summary = "static with the slaves' inertia as a first correction; may be repeated"
    iterations: float = parameter(
        1.0, unit="1", lower=1.0, upper=100.0, absent=None, doc="corrections, a whole number"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.iterations != int(self.iterations):
            raise InvalidInputError(
                "corrections are counted",
                field="iterations",
                value=self.iterations,
                allowed=bounds(1, 100, unit="corrections"),
            )

    def transformation(self, split: Partition) -> FloatArray:
        """Return T, (n, n_master)."""
        mass, stiffness, solve = split.system.mass, split.system.stiffness, split.static()
        static = static_followers(split, solve)
        slave_mass = mass[np.ix_(split.slaves, split.slaves)]
        coupling_mass = mass[np.ix_(split.slaves, split.rows)].toarray()
        followers = static
        for _ in range(int(self.iterations)):
            t = split.with_masters(followers)
            acceleration = np.linalg.solve(t.T @ (mass @ t), t.T @ (stiffness @ t))
            followers = static + solve((coupling_mass + slave_mass @ followers) @ acceleration)
        return split.with_masters(followers)

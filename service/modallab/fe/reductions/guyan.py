"""Static reduction."""

from dataclasses import dataclass

from modallab.core.arrays import FloatArray
from modallab.fe.partition import Partition
from modallab.fe.reduction import REDUCTIONS, Reduction
from modallab.fe.static_followers import static_followers


@REDUCTIONS.register("guyan")
@dataclass(frozen=True)
class Guyan(Reduction):
    """Static (Guyan) reduction: x_s = -K_ss^-1 K_sm x_m.

    Exact for static forces on masters; its frequencies are upper bounds, near where slaves carry
    little mass. Guyan, R. J. (1965), AIAA Journal 3(2), 380; Irons, B. (1965), AIAA Journal 3(5), 961-962.
    """

    kind = "guyan"
    summary = "slaves follow statically: exact at 0 Hz, frequencies too high"

    def transformation(self, split: Partition) -> FloatArray:
        """Return T, (n, n_master)."""
        return split.with_masters(static_followers(split, split.static()))

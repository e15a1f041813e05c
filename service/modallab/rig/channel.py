"""Channel of the analyser: motions that it picks up, and its filters."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof

Filter = Callable[[FloatArray], ComplexArray]  # omega (n_freq,) rad/s -> (n_freq,)


@dataclass(frozen=True)
class Channel:
    """A force or response channel.

    A response channel's input is a weighted sum of the structure's accelerations; an ideal channel's is
    a single one with weight 1. Effects add to the sum and append filters, so their order does not matter.
    """

    dof: Dof  # that the log book names
    force: bool = False
    pickups: tuple[tuple[Dof, float], ...] = ()
    filters: tuple[Filter, ...] = ()

    @classmethod
    def ideal(cls, dof: Dof, *, force: bool = False) -> "Channel":
        """Return a channel that shows the motion of its DoF."""
        return cls(dof, force, ((dof, 1.0),))

    def with_pickup(self, dof: Dof, weight: float) -> "Channel":
        """Return the channel with one more motion that it picks up."""
        return replace(self, pickups=(*self.pickups, (dof, weight)))

    def with_filter(self, filter_: Filter) -> "Channel":
        """Return the channel with one more filter in series."""
        return replace(self, filters=(*self.filters, filter_))

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return the product of all filters, (n_freq,) at `omega` rad/s."""
        product = np.ones(len(omega), complex)
        for filter_ in self.filters:
            product = product * filter_(omega)
        return product

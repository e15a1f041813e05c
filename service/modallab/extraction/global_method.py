"""What a global method is: the poles of all FRFs at once, at rising model orders."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.registry import Family


@dataclass(frozen=True, eq=False)
class Poles:
    """Every pole with positive frequency and damping, of all orders; rising order, then frequency."""

    order: IntArray  # (n_poles,) of the polynomial
    pole: ComplexArray  # (n_poles,) s = -zeta omega_r + i omega_r sqrt(1 - zeta^2), rad/s
    vector: (
        ComplexArray  # (n_poles, n_vector) by which the same pole of two orders is known again; may be 0 wide
    )

    def __post_init__(self) -> None:
        n = len(self.order)
        object.__setattr__(self, "order", frozen(self.order, int, (n,), name="order"))
        object.__setattr__(self, "pole", frozen(self.pole, complex, (n,), name="pole"))
        object.__setattr__(self, "vector", frozen(self.vector, complex, (n, None), name="vector"))

    @property
    def frequency(self) -> FloatArray:
        """(n_poles,) |s|/2 pi, Hz."""
        return np.asarray(np.abs(self.pole) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(n_poles,) twice the damping ratio."""
        return np.asarray(-2 * self.pole.real / np.abs(self.pole))


class GlobalMethod(Protocol):
    """Returns the poles of all FRFs together.

    Parameters
    ----------
    freq
        (n_freq,) Hz, equally spaced, the band that holds the modes.
    frf
        (n_freq, n_out, n_in) responses of any kind, m/N or its derivatives.
    weight
        (n_freq, n_out, n_in) one over E|error|^2 of each line; 0 leaves a line out.
    orders
        (n_orders,) rising: of the polynomials, so that a chart of n orders costs one set of sums.
    """

    def __call__(
        self, freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray
    ) -> Poles: ...


GLOBAL_METHODS: Family[GlobalMethod] = Family(
    "global extraction method", home="modallab.extraction.global_methods"
)

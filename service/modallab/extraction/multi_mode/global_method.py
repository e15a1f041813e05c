"""What a global method is: the poles of all FRFs at once, at rising model orders."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.registry import Family, first_line
from modallab.extraction.options import GlobalOptions


@dataclass(frozen=True, eq=False)
class Poles:
    """Every pole inside the band with positive damping, of all orders; rising order, then frequency."""

    orders: IntArray  # (n_orders,) rising: of the chart, also those that have no such pole
    order: IntArray  # (n_poles,) of the polynomial
    pole: ComplexArray  # (n_poles,) s = -zeta omega_r + i omega_r sqrt(1 - zeta^2), rad/s
    # (n_poles, n_out * n_in) residue in every FRF, unit of the FRF times rad/s: by its direction a pole is
    # known again at another order
    vector: ComplexArray
    # (n_poles,) of the pole's part of the FRFs: its norm over the lines against the standard error of one
    # line, rms over the FRFs; a pole that fits noise has about 1
    strength: FloatArray
    spacing: float  # Hz, of the lines: much finer than that no pole is resolved
    # (n_poles, n_in) how strongly each input reaches the pole's mode: residues are a shape times that; None
    # of a method that takes each FRF by itself
    participation: ComplexArray | None = None

    def __post_init__(self) -> None:
        n = len(self.order)
        object.__setattr__(self, "orders", frozen(self.orders, int, (None,), name="orders"))
        object.__setattr__(self, "order", frozen(self.order, int, (n,), name="order"))
        object.__setattr__(self, "pole", frozen(self.pole, complex, (n,), name="pole"))
        object.__setattr__(self, "vector", frozen(self.vector, complex, (n, None), name="vector"))
        object.__setattr__(self, "strength", frozen(self.strength, float, (n,), name="strength"))
        if self.participation is not None:
            reach = frozen(self.participation, complex, (n, None), name="participation")
            object.__setattr__(self, "participation", reach)

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

    Raises
    ------
    InvalidInputError
        If there are too few lines for such orders.
    """

    def __call__(self, freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
        """Return the poles of every order."""
        ...


@dataclass(frozen=True)
class RegisteredGlobalMethod:
    """A global method with its options."""

    find: GlobalMethod
    """Poles of all FRFs together at rising orders."""
    options: type[GlobalOptions] = GlobalOptions
    """Options dataclass of the method."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.find)

    def __call__(self, freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
        """Return the poles of every order."""
        return self.find(freq, frf, weight, orders)


GLOBAL_METHODS: Family[RegisteredGlobalMethod] = Family(
    "global extraction method", home="modallab.extraction.multi_mode.global_methods"
)

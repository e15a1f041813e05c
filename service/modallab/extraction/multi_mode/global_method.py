"""Interface of global methods: common poles of all FRFs at ascending model orders."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.registry import Family, first_line
from modallab.extraction.options import GlobalOptions


@dataclass(frozen=True, eq=False)
class Poles:
    """All poles inside the band with positive damping, sorted by order, then by frequency."""

    orders: IntArray
    """(n_orders,) orders of the chart, ascending, including orders without such a pole."""
    order: IntArray
    """(n_poles,) order of the polynomial of each pole."""
    pole: ComplexArray
    """(n_poles,) rad/s, s = -zeta omega_r + i omega_r sqrt(1 - zeta^2)."""
    vector: ComplexArray
    """(n_poles, n_out * n_in) residues in all FRFs, unit of the FRF times rad/s; the direction of this vector
    identifies a pole at different orders."""
    strength: FloatArray
    """(n_poles,) norm over the lines of the pole's contribution to an FRF over the standard error of one
    line, rms over the FRFs; about 1 for a pole that fits noise."""
    spacing: float
    """Hz, spacing of the lines."""
    participation: ComplexArray | None = None
    """(n_poles, n_in) participation factors of the inputs; residues are a shape times these. None for
    methods that treat each FRF separately."""

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
    """Function that returns the common poles of all FRFs.

    Parameters
    ----------
    freq
        (n_freq,) Hz, equally spaced lines of the band.
    frf
        (n_freq, n_out, n_in) responses of any kind, m/N or its derivatives.
    weight
        (n_freq, n_out, n_in) one over E|error|^2 of each line; 0 leaves a line out.
    orders
        (n_orders,) orders of the polynomials, ascending; all orders of a chart use one set of sums.

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

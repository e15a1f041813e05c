"""What an extraction looks like: one fit, the stabilisation chart, mode indicators, reciprocity."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes

    BoolArray = NDArray[np.bool_]
    IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class FitPicture:
    """One mode in one FRF: lines as measured, freed of leakage and other modes, and the fit through them."""

    mode: int  # counted from 1
    response: str
    method: str
    damping: str  # viscous: what lies along an axis of the details is omega, rad/s, instead of omega^2
    kind: str  # of all responses here
    freq: FloatArray = field(repr=False)  # (n_lines,) Hz
    used: "BoolArray" = field(repr=False)  # (n_lines,) False where a line was left out
    measured: ComplexArray = field(repr=False)  # (n_lines,)
    cleaned: ComplexArray = field(repr=False)  # (n_lines,)
    curve_freq: FloatArray = field(repr=False)  # (n_curve,) Hz
    curve: ComplexArray = field(repr=False)  # (n_curve,) mode and residual
    frequency: float  # Hz
    loss_factor: float
    modal_constant: complex  # 1/kg, of receptance
    residual: complex  # unit of the responses
    quality: Mapping[str, float]  # what only this method can tell, in %
    details: Mapping[str, NDArray[Any]] = field(repr=False)  # what the method draws, by name

    def plot(self) -> "tuple[Axes, ...]":
        """Draw magnitude, Nyquist plot and what is the method's own; return the axes.

        Circle-fit: the circle, and the loss factor of every pair of lines. Line-fit, Dobson, linear fit:
        their straight lines. Peak-picking: peak and half-power points.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.fit(self)


@dataclass(frozen=True, eq=False)
class Indicators:
    """Mode indicator functions: dips of `mif` and peaks of `cmif` are modes."""

    freq: FloatArray  # (n,) Hz
    inputs: tuple[str, ...]
    mif: FloatArray  # (n_in, n) 0 at a mode, towards 1 between
    cmif: FloatArray  # (k, n) m/(s N), singular values, the largest first

    def plot(self) -> "tuple[Axes, Axes]":
        """Draw CMIF over MIF; return both axes."""
        return _plots.indicators(self)


@dataclass(frozen=True, eq=False)
class StabilisationChart:
    """Poles that a global method found at rising orders, and which of them became modes."""

    order: "IntArray" = field(repr=False)  # (n_poles,)
    frequency: FloatArray = field(repr=False)  # (n_poles,) Hz
    loss_factor: FloatArray = field(repr=False)  # (n_poles,)
    # (n_poles,) 0 new at its order, 1 steady in frequency, 2 and in damping, 3 and in its vector
    stability: "IntArray" = field(repr=False)
    mode: "IntArray" = field(repr=False)  # (n_poles,) which it speaks for, counted from 1; 0 for none
    modes: FloatArray  # (n_modes,) Hz
    notes: tuple[str, ...] = ()  # why each mode is one, and what was left out
    indicators: Indicators | None = field(repr=False, default=None)

    def plot(self) -> "Axes":
        """Draw order over frequency, by stability, the modes and the CMIF behind; return the axes."""
        return _plots.chart(self)


@dataclass(frozen=True)
class ModalPair:
    """One mode as two tests see it that drive at each other's response."""

    modes: tuple[int, int]  # of the one model and of the other, counted from 1
    ratio: complex  # of the modal constants: 1 if reciprocal
    ratio_error: float  # standard error of either part
    differs: bool  # beyond its standard error


@dataclass(frozen=True)
class ReciprocalPair:
    """Two FRFs between the same points."""

    response: str
    force: str
    scale: complex  # H_jk = scale H_kj: 1 if reciprocal, -1 if a sign is wrong
    difference: float  # rms of H_jk - H_kj over that of their mean
    misfit: float  # mean square over the random one; NaN where that is not known
    differs: bool  # beyond random error


@dataclass(frozen=True)
class Reciprocity:
    """How far FRFs differ when force and response change places."""

    pairs: tuple[ReciprocalPair, ...]
    note: str  # what the data allow

    def table(self) -> str:
        """Return the pairs as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("response", "force", "scale", "difference", "misfit", "differs")
        rows = [
            (p.response, p.force, f"{p.scale:.3f}", f"{p.difference:.2g}", f"{p.misfit:.3g}", str(p.differs))
            for p in self.pairs
        ]
        return head, rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=self.note)

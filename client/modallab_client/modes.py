"""Modal models: modes as a measurement or a file gives them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from modallab_client import _plots, _tables
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Spread:
    """How one number scatters over the FRFs it was read from; `sd` with n - 1."""

    min: float
    max: float
    mean: float
    sd: float
    n: int


@dataclass(frozen=True)
class Complexity:
    """How far the points of a mode do not move in step."""

    mpc: float  # modal phase collinearity, 1 where they do
    mean_phase: float  # rad
    mean_phase_deviation: float  # rad


@dataclass(frozen=True, eq=False)
class Wander:
    """Frequencies that differ between FRFs by more than their random error; NaN where one is mute."""

    cause: str  # roving_mass, squared_shape, steady_drift or unknown
    size: float  # kg that rove, or relative drift from the first FRF to the last
    size_error: float
    unit: str
    explained: float  # 0 to 1, the part of the scatter that goes with the cause
    shift: FloatArray  # (n_modes, n_frf) Hz, from the plain mean of each mode
    shift_error: FloatArray  # (n_modes, n_frf) Hz, standard errors
    still_frequency: FloatArray  # (n_modes,) Hz, without the roving mass, or before the drift


@dataclass(frozen=True)
class Mode:
    """One mode of a modal model."""

    frequency: float  # Hz
    loss_factor: float
    frequency_spread: Spread | None
    loss_factor_spread: Spread | None
    standard_errors: Mapping[str, float]  # of frequency (Hz) and loss_factor
    flags: tuple[str, ...]
    complexity: Complexity | None = None


@dataclass(frozen=True, eq=False)
class ModalModel:
    """Modes found in a measurement, in rising frequency."""

    id: str
    modes: tuple[Mode, ...]
    method: str
    measurement_id: str | None
    dofs: tuple[str, ...]
    shapes: ComplexArray = field(repr=False)  # (n_dof, n_modes) 1/sqrt(kg)
    # (n_modes, n_frf) in the order of `frfs`; None for a model not read from FRFs, NaN where one is mute
    modal_constants: ComplexArray | None = field(repr=False, default=None)  # 1/kg
    fitted_frequencies: FloatArray | None = field(repr=False, default=None)  # Hz
    fitted_loss_factors: FloatArray | None = field(repr=False, default=None)
    shape_errors: FloatArray | None = field(repr=False, default=None)  # (n_dof, n_modes) of |shape|
    # (n_modes, n_frf) 1/kg, standard error of either part
    modal_constant_errors: FloatArray | None = field(repr=False, default=None)
    choices: Mapping[str, str] = field(repr=False, default_factory=dict)  # option -> what was taken, and why
    # FRF -> rms of what modes and residuals leave over rms of the FRF
    resynthesis_error: Mapping[str, float] | None = field(repr=False, default=None)
    wander: Wander | None = field(repr=False, default=None)  # None where frequencies agree over the FRFs
    notes: tuple[str, ...] = field(repr=False, default=())
    references: tuple[str, ...] = ()  # that FRFs share: drive points, or responses while a hammer roved
    frfs: tuple[str, ...] = field(repr=False, default=())  # a DoF, of several references "5:+Y / 1:+Y"

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def loss_factors(self) -> FloatArray:
        """(n_modes,)."""
        return np.array([mode.loss_factor for mode in self.modes])

    def table(self) -> str:
        """Return frequency and loss factor of each mode, and how they scatter over the FRFs, as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("mode", "quantity", "value", "min", "max", "mean", "sd")
        rows = []
        for number, mode in enumerate(self.modes, 1):
            frequency = _scatter(mode.frequency, mode.frequency_spread)
            loss_factor = _scatter(mode.loss_factor, mode.loss_factor_spread)
            rows.append((str(number), "frequency Hz", *frequency))
            rows.append(("", "loss factor", *loss_factor))
        return head, rows

    def plot(self) -> "Axes":
        """Draw loss factor over frequency, with the standard deviations over the FRFs; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.modal_model(self)

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Modal model {self.id}, {self.method}")


def _scatter(value: float, spread: Spread | None) -> tuple[str, ...]:
    if spread is None:
        return (f"{value:.5g}", "", "", "", "")
    return tuple(f"{x:.5g}" for x in (value, spread.min, spread.max, spread.mean, spread.sd))

"""Modal models: arrays, tables and pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client._read import read_as
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import ModalModel, Mode, Spread


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyInconsistencyMethods:
    """Frequency shifts of each FRF."""

    shift: FloatArray = field(repr=False)
    """Hz, (n_modes, n_frf) from the unweighted mean of each mode; NaN where an FRF does not show it."""
    shift_error: FloatArray = field(repr=False)
    """Hz, (n_modes, n_frf) standard errors."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ModalModelMethods:
    """Shapes, constants of each FRF, a table and a picture."""

    shapes: ComplexArray = field(repr=False)
    """(n_dof, n_modes) 1/sqrt(kg)."""
    modal_constants: ComplexArray | None = field(repr=False, default=None)
    """1/kg, (n_modes, n_frf) in the order of `frfs`; None for modes that were not extracted from FRFs."""
    fitted_frequencies: FloatArray | None = field(repr=False, default=None)
    """Hz, (n_modes, n_frf); NaN where an FRF does not show the mode."""
    fitted_loss_factors: FloatArray | None = field(repr=False, default=None)
    """(n_modes, n_frf)."""
    shape_errors: FloatArray | None = field(repr=False, default=None)
    """1/sqrt(kg), (n_dof, n_modes) standard errors of the magnitudes."""
    modal_constant_errors: FloatArray | None = field(repr=False, default=None)
    """1/kg, (n_modes, n_frf) standard error of the real and of the imaginary part."""
    if TYPE_CHECKING:
        id: str
        method: str
        modes: tuple[Mode, ...]

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
        return _plots.modal_model(cast("ModalModel", self))

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Modal model {self.id}, {self.method}")


def _scatter(value: float, spread: "Spread | None") -> tuple[str, ...]:
    if spread is None:
        return (f"{value:.5g}", "", "", "", "")
    return tuple(f"{x:.5g}" for x in (value, spread.min, spread.max, spread.mean, spread.sd))


def modal_model_of(data: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> "ModalModel":
    """Return a modal model from its JSON and the arrays of its npz file."""
    from modallab_client._generated.models import FrequencyInconsistency, ModalModel

    names = {"fitted_frequency": "fitted_frequencies", "fitted_loss_factor": "fitted_loss_factors"}
    served = ("shapes", "modal_constants", "shape_errors", "modal_constant_errors", *names)
    fields: dict[str, Any] = {names.get(name, name): arrays[name] for name in served if name in arrays}
    data_inconsistency = data.get("frequency_inconsistency")
    if data_inconsistency is not None:
        shifts: dict[str, Any] = {
            name: arrays[f"frequency_inconsistency_{name}"] for name in ("shift", "shift_error")
        }
        fields["frequency_inconsistency"] = read_as(FrequencyInconsistency, data_inconsistency, **shifts)
    return read_as(ModalModel, data, **fields)

"""Fits and stabilisation charts: arrays and pictures."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client._read import read_as
from modallab_client.models import IntArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import FitPlotData, StabilisationChart


class FitPlotDataMethods:
    """A picture of one fit, and its numbers."""

    if TYPE_CHECKING:
        mode: int
        method: str
        response: str
        frequency: float
        loss_factor: float

    def _repr_html_(self) -> str:
        rows = [
            ("frequency", f"{self.frequency:.6g} Hz"),
            ("loss factor", f"{self.loss_factor:.4g}"),
        ]
        return _tables.html(
            (), rows, caption=f"Mode {self.mode} in the FRF at {self.response}, {self.method}"
        )

    def plot(self) -> "tuple[Axes, ...]":
        """Draw magnitude, Nyquist plot and the plot of the method; return the axes.

        Circle fit: the circle, and the loss factor of every pair of lines. Line fit, Dobson, linear fit:
        their straight lines. Peak picking: peak and half-power points.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.fit(cast("FitPlotData", self))


class StabilisationChartMethods:
    """A picture of the chart, and its modes."""

    if TYPE_CHECKING:
        modes: tuple[float, ...]
        order: IntArray

    def _repr_html_(self) -> str:
        rows = [(str(number), f"{frequency:.6g}") for number, frequency in enumerate(self.modes, 1)]
        caption = f"Stabilisation chart of {len(self.order)} poles"
        return _tables.html(("mode", "frequency Hz"), rows, caption=caption)

    def plot(self) -> "Axes":
        """Draw order over frequency, by stability, the modes and the CMIF behind; return the axes."""
        return _plots.chart(cast("StabilisationChart", self))


def fit_of(data: Mapping[str, Any]) -> "FitPlotData":
    """Return a fit; its details are arrays, the complex ones among them."""
    from modallab_client._generated.models import FitPlotData

    real = {name: _read_only(np.array(values, dtype=float)) for name, values in data["details"].items()}
    turning = {name: _complex(values) for name, values in data["complex_details"].items()}
    return read_as(FitPlotData, data, details=real | turning, complex_details=turning)


def _complex(pairs: Any) -> NDArray[Any]:
    values = np.array(pairs, dtype=float)
    return _read_only(np.asarray(values[..., 0] + 1j * values[..., 1]))


def _read_only(values: NDArray[Any]) -> NDArray[Any]:
    values.setflags(write=False)
    return values

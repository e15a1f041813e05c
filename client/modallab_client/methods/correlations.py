"""Correlations: the FDAC, tables and pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client._read import read_as
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import Correlation, Orthogonality, ResponseCorrelation


@dataclass(frozen=True, eq=False, kw_only=True)
class ResponseCorrelationMethods:
    """The frequency domain assurance criterion (FDAC) and pictures."""

    freq: FloatArray = field(repr=False)
    """Hz, (n_lines,) lines of both axes of the FDAC."""
    fdac: FloatArray = field(repr=False)
    """(n_in, n_lines, n_lines) FDAC, measured by model line, 0 to 1."""
    if TYPE_CHECKING:
        inputs: tuple[str, ...]

    def plot(self, drive: str | None = None) -> "Axes":
        """Draw the FDAC of an input, by default the first, with its ridge; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such input.
        """
        correlation = cast("ResponseCorrelation", self)
        return _plots.fdac(correlation, self.inputs[0] if drive is None else drive)

    def plot_frac(self) -> "Axes":
        """Draw the frequency response assurance criterion (FRAC) of every FRF; return the axes."""
        return _plots.frac(cast("ResponseCorrelation", self))


class CorrelationMethods:
    """A correlation has a table and pictures."""

    if TYPE_CHECKING:
        mac: FloatArray
        pairs: tuple[tuple[int, int], ...]
        frequency_differences: FloatArray
        comac: FloatArray
        orthogonality: Orthogonality | None

    @property
    def cross_orthogonality(self) -> FloatArray | None:
        """(n_measured, n_model) orthogonality of measured and computed modes; None without a reduction."""
        return None if self.orthogonality is None else self.orthogonality.cross

    @property
    def auto_orthogonality(self) -> FloatArray | None:
        """(n_measured, n_measured) orthogonality of the measured modes; None without a reduction."""
        return None if self.orthogonality is None else self.orthogonality.auto

    def plot(self) -> "Axes":
        """Draw the MAC matrix; return the axes."""
        return _plots.mac(cast("Correlation", self))

    def plot_coordinates(self) -> "tuple[Axes, Axes]":
        """Draw CoMAC and, below, ECoMAC of every DoF; return both axes."""
        return _plots.coordinates(cast("Correlation", self))

    def plot_orthogonality(self) -> "tuple[Axes, Axes]":
        """Draw cross- and auto-orthogonality side by side; return both axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If no reduction was asked for.
        """
        return _plots.orthogonality(cast("Correlation", self))

    def table(self) -> str:
        """Return the pairs with their frequency differences and MAC as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head: tuple[str, ...] = ("measured", "model", "difference Hz", "MAC")
        cross = self.cross_orthogonality
        if cross is not None:
            head = (*head, "orthogonality")
        rows = []
        for (measured, model), difference in zip(self.pairs, self.frequency_differences, strict=True):
            pair = measured - 1, model - 1
            cells = (str(measured), str(model), f"{difference:+.4g}", f"{self.mac[pair]:.4f}")
            rows.append(cells if cross is None else (*cells, f"{cross[pair]:.4f}"))
        return head, rows

    def _repr_html_(self) -> str:
        caption = f"Correlation at {len(self.comac)} degrees of freedom"
        return _tables.html(*self._rows(), caption=caption)


def correlation_of(data: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None) -> "Correlation":
    """Return a correlation from its JSON and, where FRFs were compared, the arrays of its npz file."""
    from modallab_client._generated.models import Correlation, ResponseCorrelation

    if arrays is None:
        return read_as(Correlation, data)
    lines = {"freq": arrays["fdac_freq"], "fdac": arrays["fdac"]}
    responses = read_as(ResponseCorrelation, data["responses"], **lines)
    return read_as(Correlation, data, responses=responses)

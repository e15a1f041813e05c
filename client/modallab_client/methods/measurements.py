"""Measurements: arrays, tables and pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab_client import _frames, _plots, _tables
from modallab_client._frf_plots import FrfPictures
from modallab_client._read import read_as
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import Indicators, Measurement, ReciprocalPair


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasurementMethods(FrfPictures):
    """FRFs, coherence and auto spectra, a table and a picture."""

    freq: FloatArray = field(repr=False)
    """Hz, (n,) lines."""
    values: ComplexArray = field(repr=False)
    """(n, n_out, n_in) FRFs in the unit of `kind`."""
    coherence: FloatArray | None = field(repr=False, default=None)
    """1, (n, n_out), with a roving hammer (n, n_out, n_in)."""
    force_spectrum: FloatArray | None = field(repr=False, default=None)
    """N^2/Hz, (n, n_out, n_in) force auto spectra."""
    response_spectrum: FloatArray | None = field(repr=False, default=None)
    """unit^2/Hz, response auto spectra, shaped as `coherence`."""
    input_condition: FloatArray | None = field(repr=False, default=None)
    """1, (n,) condition number of the force spectra, with several simultaneous forces."""
    force_cross_spectra: ComplexArray | None = field(repr=False, default=None)
    """N^2/Hz, (n, n_out, n_in, n_in) cross spectra of several simultaneous forces."""
    if TYPE_CHECKING:
        id: str
        kind: Any
        outputs: tuple[str, ...]
        inputs: tuple[str, ...]
        averages: float

    def __repr__(self) -> str:
        n, n_out, n_in = self.values.shape
        return (
            f"Measurement({self.id!r}, {self.kind}, {n_out} outputs x {n_in} inputs, "
            f"{n} lines from {self.freq[0]:g} to {self.freq[-1]:g} Hz)"
        )

    def plot(self) -> "tuple[Axes, Axes]":
        """Draw the magnitude of every FRF, and the coherence below it; return both axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.measurement(cast("Measurement", self))

    def to_xarray(self) -> Any:
        """Return an `xarray.Dataset` of FRFs, coherence and auto spectra by `freq`, `output` and `input`.

        Raises
        ------
        MissingExtraError
            If xarray is not installed.
        """
        return _frames.measurement(cast("Measurement", self))

    def summary(self) -> str:
        """Return kind, size, lines, averages and median coherence in one sentence."""
        n, n_out, n_in = self.values.shape
        words = [
            f"{self.kind} of {n_out} response{'s' * (n_out > 1)} and {n_in} force{'s' * (n_in > 1)}",
            f"{n} lines from {self.freq[0]:g} to {self.freq[-1]:g} Hz",
            "averages unknown" if np.isnan(self.averages) else f"{self.averages:.4g} averages",
        ]
        if self.coherence is not None:
            words.append(f"median coherence {np.nanmedian(self.coherence):.4f}")
        return ", ".join(words)

    def _repr_html_(self) -> str:
        rows = [
            ("kind", self.kind),
            ("outputs", ", ".join(self.outputs)),
            ("inputs", ", ".join(self.inputs)),
            ("lines", f"{len(self.freq)} from {self.freq[0]:g} to {self.freq[-1]:g} Hz"),
            ("averages", "unknown" if np.isnan(self.averages) else f"{self.averages:g}"),
        ]
        if self.coherence is not None:
            rows.append(("coherence, median", f"{np.median(self.coherence):.4f}"))
        return _tables.html((), rows, caption=f"Measurement {self.id}")


class IndicatorsMethods:
    """A picture of mode indicator functions, and their lines."""

    if TYPE_CHECKING:
        freq: FloatArray
        inputs: tuple[str, ...]

    def _repr_html_(self) -> str:
        rows = [
            ("inputs", ", ".join(self.inputs)),
            ("lines", f"{len(self.freq)} from {self.freq[0]:g} to {self.freq[-1]:g} Hz"),
        ]
        return _tables.html((), rows, caption="Mode indicator functions")

    def plot(self) -> "tuple[Axes, Axes]":
        """Draw CMIF over MIF; return both axes."""
        return _plots.indicators(cast("Indicators", self))


class ReciprocityCheckMethods:
    """A table of pairs."""

    if TYPE_CHECKING:
        pairs: tuple[ReciprocalPair, ...]
        note: str

    def table(self) -> str:
        """Return the pairs as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("response", "force", "scale", "difference", "misfit", "differs")
        rows = []
        for pair in self.pairs:
            misfit = "" if pair.misfit is None else f"{pair.misfit:.3g}"
            figures = (f"{pair.scale:.3f}", f"{pair.difference:.2g}", misfit, str(pair.differs))
            rows.append((pair.response, pair.force, *figures))
        return head, rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=self.note)


def measurement_of(data: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> "Measurement":
    """Return a measurement from its JSON and the arrays of its npz file, which may be of another kind."""
    from modallab_client._generated.models import Measurement

    spectra = ("coherence", "force_spectrum", "response_spectrum", "input_condition", "force_cross_spectra")
    fields: dict[str, Any] = {name: arrays[name] for name in spectra if name in arrays}
    fields |= {
        name: tuple(map(str, arrays[name])) for name in ("outputs", "inputs", "notes") if name in arrays
    }
    averages = arrays.get("averages", np.array(data.get("averages", np.nan)))
    return read_as(
        Measurement,
        data,
        **fields,
        freq=arrays["freq"],
        values=arrays["values"],
        kind=str(arrays["kind"]),
        averages=float(averages.reshape(-1)[0]) if averages.size else np.nan,
        n_lines=len(arrays["freq"]),
        frequency_min=float(arrays["freq"][0]),
        frequency_max=float(arrays["freq"][-1]),
    )

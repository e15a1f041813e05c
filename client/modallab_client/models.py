"""Results made of arrays alone: computed mode shapes and synthesised FRFs."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modallab_client import _plots, _tables
from modallab_client._frf_plots import FrfPictures
from modallab_client._shapes import ShapePictures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import Measurement

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ModeShapes(ShapePictures):
    """The elastic modes of a structure with their mass-normalised shapes."""

    frequencies: FloatArray
    """(n_modes,) Hz."""
    shapes: ComplexArray
    """(n_dof, n_modes) 1/sqrt(kg)."""
    dofs: tuple[str, ...]

    def __repr__(self) -> str:
        return f"ModeShapes({len(self.frequencies)} modes at {len(self.dofs)} DoFs)"

    def _repr_html_(self) -> str:
        rows = [(str(number), f"{frequency:.5g}") for number, frequency in enumerate(self.frequencies, 1)]
        return _tables.html(("mode", "frequency Hz"), rows, caption=f"Mode shapes at {len(self.dofs)} DoFs")


@dataclass(frozen=True, eq=False)
class Frf(FrfPictures):
    """FRFs that are made, not measured: exact ones of a structure, or those of modes."""

    freq: FloatArray
    """(n,) Hz."""
    values: ComplexArray
    """(n, n_out, 1), unit of `kind`."""
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    kind: str
    """Receptance, mobility or inertance."""
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        n, n_out, _ = self.values.shape
        last = f"{n} lines from {self.freq[0]:g} to {self.freq[-1]:g} Hz"
        return f"Frf({self.kind}, {n_out} outputs / {self.inputs[0]}, {last})"

    def _repr_html_(self) -> str:
        rows = [
            ("kind", self.kind),
            ("outputs", ", ".join(self.outputs)),
            ("inputs", ", ".join(self.inputs)),
            ("lines", f"{len(self.freq)} from {self.freq[0]:g} to {self.freq[-1]:g} Hz"),
            *(("note", note) for note in self.notes),
        ]
        return _tables.html((), rows, caption="Synthesised FRFs")

    def plot(
        self, measured: "Measurement | None" = None, *, output: str | None = None
    ) -> "tuple[Axes, Axes]":
        """Draw magnitude over phase, measured FRFs of the same kind in grey behind; return both axes.

        Parameters
        ----------
        measured
            What to hold them against.
        output
            One response alone; left out: all of them.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such response, or the measured FRFs are of another kind.
        """
        return _plots.frf(self, measured, output)

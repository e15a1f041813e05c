"""What the lab gives back: frozen values, arrays as read-only numpy, SI units and Hz.

Structures, rigs, measurements and jobs. Modal models are in `modes`, what comes of comparing in `findings`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modallab_client import _plots, _tables

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Structure:
    """A stored structure; it never changes, `structures.change` makes another."""

    id: str
    n_nodes: int
    n_dofs: int
    members: int
    name: str = ""
    groups: Mapping[str, Sequence[int]] = field(default_factory=dict, hash=False)  # members by name


@dataclass(frozen=True, eq=False)
class StructureModes:
    """The elastic modes of a structure, computed."""

    frequencies: FloatArray  # (n_modes,) Hz
    loss_factors: FloatArray  # (n_modes,)
    n_rigid_body: int

    def table(self) -> str:
        """Return number, frequency and loss factor of each mode as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        pairs = zip(self.frequencies, self.loss_factors, strict=True)
        rows = [(str(i), f"{f:.4g}", f"{eta:.4g}") for i, (f, eta) in enumerate(pairs, 1)]
        return ("mode", "frequency Hz", "loss factor"), rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"{self.n_rigid_body} rigid-body modes not listed")


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """The elastic modes of a structure with their mass-normalised shapes."""

    frequencies: FloatArray  # (n_modes,) Hz
    shapes: ComplexArray  # (n_dof, n_modes) 1/sqrt(kg)
    dofs: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Frf:
    """FRFs that are made, not measured: exact ones of a structure, or those of modes."""

    freq: FloatArray  # (n,) Hz
    values: ComplexArray  # (n, n_out, 1), unit of `kind`
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    kind: str  # receptance, mobility or inertance
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        n, n_out, _ = self.values.shape
        last = f"{n} lines from {self.freq[0]:g} to {self.freq[-1]:g} Hz"
        return f"Frf({self.kind}, {n_out} outputs / {self.inputs[0]}, {last})"

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


@dataclass(frozen=True)
class Rig:
    """A stored rig: the log book of a test, defaults filled in."""

    id: str
    drive: str = ""
    responses: tuple[str, ...] = ()
    hardware: Mapping[str, Any] = field(default_factory=dict)  # exciter, force_transducer, accelerometers
    analyser: Mapping[str, Any] = field(default_factory=dict)
    noise: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[Mapping[str, Any], ...] = ()


@dataclass(frozen=True, eq=False)
class Measurement:
    """Measured FRFs with their coherence and spectra, and nothing of how they came about."""

    id: str
    freq: FloatArray  # (n,) Hz
    values: ComplexArray  # (n, n_out, n_in), unit of `kind`
    coherence: FloatArray | None  # (n, n_out), with a roving hammer (n, n_out, n_in)
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    kind: str  # receptance, mobility or inertance
    averages: float | None
    force_spectrum: FloatArray | None = field(default=None, repr=False)  # (n, n_out, n_in) N^2/Hz
    response_spectrum: FloatArray | None = field(default=None, repr=False)  # as coherence, unit^2/Hz
    input_condition: FloatArray | None = field(default=None, repr=False)  # (n,) with several forces at once
    rig_id: str | None = None
    notes: tuple[str, ...] = ()

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
        return _plots.measurement(self)

    def _repr_html_(self) -> str:
        rows = [
            ("kind", self.kind),
            ("outputs", ", ".join(self.outputs)),
            ("inputs", ", ".join(self.inputs)),
            ("lines", f"{len(self.freq)} from {self.freq[0]:g} to {self.freq[-1]:g} Hz"),
            ("averages", "unknown" if self.averages is None else f"{self.averages:g}"),
        ]
        if self.coherence is not None:
            rows.append(("coherence, median", f"{np.median(self.coherence):.4f}"))
        return _tables.html((), rows, caption=f"Measurement {self.id}")


@dataclass(frozen=True, eq=False)
class Curve:
    """One FRF, thinned for a plot; its peaks and notches stay."""

    output: str
    input: str
    values: ComplexArray  # (n,)
    coherence: FloatArray | None  # (n,)


@dataclass(frozen=True, eq=False)
class Curves:
    """The FRFs of a measurement, thinned for plots."""

    freq: FloatArray  # (n,) Hz
    kind: str
    curves: tuple[Curve, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class MeasurementLog:
    """What was declared and asked; `rigs.create(**log.rig)` declares the same rig again."""

    id: str
    created: str  # ISO 8601, UTC
    version: str  # of modallab that measured
    libraries: Mapping[str, str]  # whose rounding is in the numbers: name -> version
    rig_id: str
    rig: Mapping[str, Any]
    route: str | None  # None where it was brought from elsewhere
    seed: int | None
    averages: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Truth:
    """What a measurement was made with; for its owner."""

    structure_id: str
    effects: tuple[Mapping[str, Any], ...]  # kind, at, parameters

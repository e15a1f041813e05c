"""FRFs and coherence of a measurement while its averages were taken."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_client import _tables
from modallab_client.models import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class Estimates:
    """FRFs and coherence after the first averages of a measurement, up to all of them."""

    n_averages: NDArray[np.int64]
    """1, (n_estimates,) averages taken, ascending."""
    freq: FloatArray = field(repr=False)
    """Hz, (n_freq,)."""
    values: ComplexArray = field(repr=False)
    """(n_estimates, n_freq, n_out, n_in) FRFs of `kind`."""
    coherence: FloatArray = field(repr=False)
    """1, (n_estimates, n_freq, n_out), with a roving hammer (n_estimates, n_freq, n_out, n_in)."""
    outputs: tuple[str, ...]
    """Response DoFs."""
    inputs: tuple[str, ...]
    """Force DoFs."""
    kind: str
    """Kind of the FRFs: receptance, mobility or inertance."""

    def _repr_html_(self) -> str:
        rows = [
            ("after averages", ", ".join(map(str, self.n_averages.tolist()))),
            ("FRFs", f"{len(self.outputs) * len(self.inputs)} of {len(self.freq)} lines, {self.kind}"),
        ]
        return _tables.html((), rows, caption="Estimates")


def estimates_of(arrays: Mapping[str, NDArray[Any]]) -> Estimates:
    """Return estimates from the arrays of their npz file."""
    return Estimates(
        n_averages=arrays["n_averages"],
        freq=arrays["freq"],
        values=arrays["values"],
        coherence=arrays["coherence"],
        outputs=tuple(map(str, arrays["outputs"])),
        inputs=tuple(map(str, arrays["inputs"])),
        kind=str(arrays["kind"]),
    )

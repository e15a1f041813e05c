"""Agreement of a model's frequency responses with the measured ones."""

from dataclasses import dataclass

from modallab.core.arrays import FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.reply import Matrix


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """Mean squares of ln(H_measured / H_model) over its random error: 1 for random errors alone."""

    freq: FloatArray
    """Hz, fitted lines (n_lines,)."""
    outputs: tuple[Dof, ...]
    """Measured DoFs."""
    inputs: tuple[Dof, ...]
    """Driven DoFs."""
    before: float
    """Mean square with nominal coefficients."""
    after: float
    """Mean square with updated coefficients."""
    scatter: float
    """Standard deviation of such a mean square by random errors alone."""
    by_frf_before: Matrix
    """Mean square of each FRF before (n_out, n_in); 0 for an unused FRF."""
    by_frf_after: Matrix
    """Mean square of each FRF after (n_out, n_in)."""
    n_held_out: int
    """Lines held out of the fit."""
    held_out_before: float | None
    """Mean square of held-out lines before; None where every line was fitted."""
    held_out_after: float | None
    """Mean square of held-out lines after; None where every line was fitted."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "freq", frozen(self.freq, float, (None,), name="freq"))
        shape = (len(self.outputs), len(self.inputs))
        for name in ("by_frf_before", "by_frf_after"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))

    @property
    def n_lines(self) -> int:
        """Number of fitted lines."""
        return len(self.freq)

    @property
    def band(self) -> tuple[float, float]:
        """Hz, lowest and highest fitted line."""
        return float(self.freq[0]), float(self.freq[-1])

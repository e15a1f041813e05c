"""How well a model's frequency responses are the measured ones."""

from dataclasses import dataclass

from modallab.core.arrays import FloatArray, frozen
from modallab.core.dof import Dof


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """Mean squares of ln(H_measured / H_model) over its random error: 1 if only that is left."""

    freq: FloatArray  # (n_lines,) Hz, of the lines that coefficients were found by
    outputs: tuple[Dof, ...]
    inputs: tuple[Dof, ...]
    before: float
    after: float
    scatter: float  # standard deviation of such a mean over the same numbers, by random error alone
    by_frf_before: FloatArray  # (n_out, n_in); 0 of an FRF that says nothing
    by_frf_after: FloatArray
    n_held_out: int  # lines that were looked at only afterwards
    held_out_before: float | None  # None where every line was used
    held_out_after: float | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "freq", frozen(self.freq, float, (None,), name="freq"))
        shape = (len(self.outputs), len(self.inputs))
        for name in ("by_frf_before", "by_frf_after"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))

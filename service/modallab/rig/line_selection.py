"""Some of the lines of an analyser."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray, frozen


@dataclass(frozen=True, eq=False)
class LineSelection:
    """Lines at which spectra are needed, by their index from 0 Hz on; equal if the indices are."""

    indices: IntArray
    """(n,) rising."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "indices", frozen(self.indices, int, np.shape(self.indices), name="lines"))

    @classmethod
    def every(cls, step: int, n_lines: int) -> "LineSelection":
        """Return every `step`-th of `n_lines` lines."""
        return cls(np.arange(0, n_lines, step))

    def __len__(self) -> int:
        return len(self.indices)

    def __hash__(self) -> int:
        return hash(self.indices.tobytes())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LineSelection) and np.array_equal(self.indices, other.indices)

    def of(self, freq: FloatArray) -> FloatArray:
        """Return the frequencies (n,) of the lines, of all `freq`."""
        return freq[self.indices]

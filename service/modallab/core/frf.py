"""Frequency response functions (FRFs) on one frequency axis."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError


class FrfKind(StrEnum):
    """Kind of response per force; each is the time derivative of the one before."""

    RECEPTANCE = "receptance"  # m/N
    MOBILITY = "mobility"  # m/(s N)
    INERTANCE = "inertance"  # m/(s^2 N)

    @classmethod
    def _missing_(cls, value: object) -> "FrfKind | None":
        """Return the kind of a synonym: accelerance is inertance."""
        return cls.INERTANCE if value == "accelerance" else None

    def steps_to(self, kind: "FrfKind") -> int:
        """Return the number of time derivatives from this kind to another; negative: integrations."""
        order = list(FrfKind)
        return order.index(kind) - order.index(self)


@dataclass(frozen=True, eq=False)
class FrfSet:
    """Frequency responses on one axis; time convention exp(+i omega t)."""

    freq: FloatArray
    """Hz, (n_freq,) frequency lines, rising, not negative."""
    values: ComplexArray
    """(n_freq, n_out, n_in) complex responses in the unit of `kind`."""
    outputs: tuple[Dof, ...]
    """Response DoFs."""
    inputs: tuple[Dof, ...]
    """Force DoFs."""
    kind: FrfKind
    """Receptance, mobility or inertance."""

    def __post_init__(self) -> None:
        shape = (len(self.freq), len(self.outputs), len(self.inputs))
        object.__setattr__(self, "freq", frozen(self.freq, float, shape[:1], name="freq"))
        object.__setattr__(self, "values", frozen(self.values, complex, shape, name="values"))
        if shape[0] == 0 or self.freq[0] < 0 or (np.diff(self.freq) <= 0).any():
            raise InvalidInputError("the frequency axis must rise from 0 Hz or above", field="freq")

    def to(self, kind: FrfKind) -> "FrfSet":
        """Return the responses converted to another kind by factors i omega.

        Raises
        ------
        InvalidInputError
            If the line at 0 Hz would have to be integrated: drop it with `between` first.
        """
        steps = self.kind.steps_to(kind)
        if self.left_out(kind):
            raise InvalidInputError(f"{self.kind} at 0 Hz has no {kind}", field="freq", value=0.0)
        factor = (2j * np.pi * self.freq) ** steps
        return replace(self, values=self.values * factor[:, None, None], kind=kind)

    def left_out(self, kind: FrfKind) -> tuple[str, ...]:
        """Return a note if the line at 0 Hz has to be left out, as it cannot be integrated to a kind."""
        if self.kind.steps_to(kind) >= 0 or self.freq[0] > 0:
            return ()
        return (f"{self.kind} at 0 Hz has no {kind}: that line is left out",)

    def between(self, lower: float, upper: float) -> "FrfSet":
        """Return the lines with lower < f <= upper, Hz."""
        keep = (self.freq > lower) & (self.freq <= upper)
        return replace(self, freq=self.freq[keep], values=self.values[keep])

    def at(self, lines: BoolArray | None) -> "FrfSet":
        """Return the lines of a mask (n_freq,); itself if there is none."""
        return self if lines is None else replace(self, freq=self.freq[lines], values=self.values[lines])

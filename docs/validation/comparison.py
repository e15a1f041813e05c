"""Printed numbers beside found ones, and how a table shows them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray

ROUNDING = 1e-9  # of a printed digit; a number half a digit away may be rounded either way
WIDEST = 12  # items that fit beside each other on a page


@dataclass(frozen=True)
class Quantity:
    """One printed quantity of all items of a table, and the same from this code."""

    name: str
    printed: FloatArray
    found: FloatArray
    decimals: int
    reason: str = ""  # why a number differs by more than its last digit

    @property
    def deviations(self) -> FloatArray:
        """Found less printed."""
        return self.found - self.printed

    @property
    def beyond(self) -> Any:
        """Which numbers differ by more than half of the last printed digit, (n_items,) of bool."""
        return np.abs(self.deviations) > (0.5 + ROUNDING) * 10.0**-self.decimals

    @property
    def cells(self) -> tuple[list[str], list[str], list[str], str]:
        """Printed, found, deviation and reason as text; what differs by more than its last digit is bold."""
        printed = [f"{value:.{self.decimals}f}" for value in self.printed]
        finer = self.decimals + 1
        found = [f"{value:.{finer}f}" for value in self.found]
        signed = [f"{value:+.{finer}f}" for value in np.round(self.deviations, finer) + 0.0]  # no -0.0
        deviation = [f"**{text}**" if off else text for text, off in zip(signed, self.beyond, strict=True)]
        return printed, found, deviation, self.reason if self.beyond.any() else ""


def quantity(name: str, printed: Any, found: Any, decimals: int, reason: str = "") -> Quantity:
    """Return a quantity from numbers or sequences of them."""
    of_print, of_code = (np.atleast_1d(np.asarray(one, dtype=float)) for one in (printed, found))
    return Quantity(name, of_print, of_code, decimals, reason)


@dataclass(frozen=True)
class Comparison:
    """A published table beside the same numbers from this code."""

    number: str
    title: str
    quantities: tuple[Quantity, ...]
    label: str = ""  # of the items, such as "mode"; none where each quantity is a single number
    items: Sequence[str] = ()
    notes: Sequence[str] = ()

    def __post_init__(self) -> None:
        for one in self.quantities:
            if one.printed.shape != one.found.shape or len(one.printed) != max(len(self.items), 1):
                raise ValueError(f"{self.number}, {one.name}: {one.printed.shape} and {one.found.shape}")
            if bool(one.beyond.any()) != bool(one.reason):
                raise ValueError(f"{self.number}, {one.name}: {one.deviations}, reason {one.reason!r}")

    @property
    def n_numbers(self) -> int:
        """How many numbers are compared."""
        return sum(len(one.printed) for one in self.quantities)

    @property
    def n_beyond(self) -> int:
        """How many of them differ by more than the last printed digit."""
        return int(sum(one.beyond.sum() for one in self.quantities))

    def markdown(self) -> str:
        """Return the section of the report."""
        if not self.items:
            lines = self._single_numbers()
        elif len(self.items) > WIDEST:
            lines = self._items_down()
        else:
            lines = self._items_across()
        notes = "".join(f"\n\n{note}" for note in self.notes)
        return f"## {self.number}: {self.title}\n\n" + "\n".join(lines) + notes

    def _single_numbers(self) -> list[str]:
        rows = [
            [one.name, printed[0], found[0], deviation[0], reason]
            for one, (printed, found, deviation, reason) in ((one, one.cells) for one in self.quantities)
        ]
        return _table(["", "printed", "modallab", "deviation", "reason"], rows)

    def _items_across(self) -> list[str]:
        rows, reasons = [], []
        for one in self.quantities:
            printed, found, deviation, reason = one.cells
            rows += [[one.name, "printed", *printed], ["", "modallab", *found], ["", "deviation", *deviation]]
            if reason:
                items = ", ".join(item for item, off in zip(self.items, one.beyond, strict=True) if off)
                reasons.append(f"- {one.name}, {self.label} {items}: {reason}.")
        return [*_table(["", self.label, *self.items], rows), *[""][: len(reasons)], *reasons]

    def _items_down(self) -> list[str]:
        header, columns = [self.label], [list(self.items)]
        for one in self.quantities:
            header += [f"{one.name}, printed", "modallab", "deviation"]
            columns += one.cells[:3]
        reasons = [
            "; ".join(one.reason for one in self.quantities if one.beyond[row])
            for row in range(len(self.items))
        ]
        return _table([*header, "reason"], [list(row) for row in zip(*columns, reasons, strict=True)])


def _table(header: list[str], rows: list[list[str]]) -> list[str]:
    if header[-1] == "reason" and not any(row[-1] for row in rows):
        header, rows = header[:-1], [row[:-1] for row in rows]
    lines = [header, ["---"] * len(header), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]

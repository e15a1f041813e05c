"""Tables that compare numbers of the lab with printed ones, one column a mode."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from modallab_client import _tables
from modallab_client.models import FloatArray


@dataclass(frozen=True)
class Line:
    """A quantity as the lab computes it and as it is printed."""

    quantity: str
    computed: Sequence[float] | FloatArray
    printed: Sequence[float]
    digits: int


@dataclass(frozen=True)
class ComparisonTable:
    """A printed table compared with the lab's."""

    title: str
    lines: tuple[Line, ...]
    note: str = ""

    def text(self) -> str:
        """Return both as text for a terminal."""
        note = f"\n{self.note}" if self.note else ""
        return f"{self.title}\n{_tables.text(*self._rows())}{note}"

    def html(self) -> str:
        """Return both as an HTML table, every cell escaped."""
        return _tables.html(*self._rows(), caption=f"{self.title}. {self.note}".strip())

    def _rows(self) -> _tables.Table:
        head = ("", "", *(str(mode) for mode in range(1, len(self.lines[0].computed) + 1)))
        rows = []
        for line in self.lines:
            rows.append((line.quantity, "lab", *_digits(line.computed, line.digits)))
            rows.append(("", "thesis", *_digits(line.printed, line.digits)))
        return head, rows


def _digits(values: Iterable[float], digits: int) -> list[str]:
    return [f"{value:.{digits}f}" for value in values]

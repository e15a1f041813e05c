"""Mode shape of one dataset 55, of any program."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import bounds
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_split import refusal

_NORMAL, _COMPLEX = 2, (3, 7)  # analysis types
_VALUES = (1, 2, 3, 6)  # of a node
_STRANGE = re.compile(r"[^0-9+\-.eEdD ]")
_MODE_COUNT = re.compile(r"modallab, mode \d+ of (\d+)")
_FORTRAN = str.maketrans("dD", "EE")


@dataclass(frozen=True, eq=False)
class NodalShape:
    """Mode in the units of the file; frequency 0 for rigid-body modes and complex conjugates."""

    frequency: float  # Hz
    loss_factor: float
    modal_mass: complex | None
    nodes: tuple[int, ...]
    values: ComplexArray  # (n_nodes, 3 or 6)
    of: int | None  # how many modes the file had when it was written, where it says so


def read_shape(text: str, index: int) -> NodalShape | None:
    """Return the mode of a dataset 55; None if it has another analysis type.

    Parameters
    ----------
    text
        Its lines, without mark and number.
    index
        Which mode of the file it is, counted from 1: for the error.

    Raises
    ------
    InvalidInputError
        If a record is missing, or holds what is no number.
    """
    if len(text) > UNIVERSAL.max_shape_characters:
        raise refusal(f"mode {index} has too many nodes", allowed=bounds(1, UNIVERSAL.max_shape_nodes))
    lines = [line.rstrip() for line in text.split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    reader = _Reader(lines, index)
    kinds = reader.integers(5, 6)
    analysis, form, width = kinds[1], kinds[4], kinds[5]
    if analysis != _NORMAL and analysis not in _COMPLEX:
        return None
    if form not in (2, 5) or width not in _VALUES:
        raise refusal(
            f"mode {index} has shapes of another form",
            field="shape",
            value=f"data type {form}, {width} values a node",
            allowed="real or complex (2, 5), 1, 2, 3 or 6 values a node",
        )
    count = width * (2 if form == 5 else 1)
    nodes, entries = reader.nodes(count)
    values = entries.astype(complex) if form == 2 else entries[:, ::2] + 1j * entries[:, 1::2]
    table = np.zeros((len(nodes), 6 if width == 6 else 3), complex)
    table[:, :width] = values
    match = _MODE_COUNT.match(lines[1])
    frequency, loss_factor, mass = (_normal if analysis == _NORMAL else _complex)(reader.numbers(7))
    # Velocities and accelerations have another scale than the displacements of the modal mass.
    scaled = kinds[3] in (0, 8) and mass
    if not np.isfinite([frequency, loss_factor, np.abs(mass or 0.0)]).all():
        raise refusal(f"mode {index} is out of bounds", field="frequency", value=f"{frequency:g} Hz")
    return NodalShape(
        frequency, loss_factor, mass if scaled else None, nodes, table, int(match[1]) if match else None
    )


def _normal(record: Sequence[float]) -> tuple[float, float, complex | None]:
    frequency, mass, viscous, hysteretic = (*record, 0.0, 0.0, 0.0)[:4]
    return max(frequency, 0.0), hysteretic or 2 * viscous, mass if mass > 0 else None


def _complex(record: Sequence[float]) -> tuple[float, float, complex | None]:
    eigenvalue = complex(*(*record, 0.0, 0.0)[:2])
    modal_a = complex(*(*record, 0.0, 0.0, 0.0, 0.0)[2:4])
    omega = float(np.hypot(eigenvalue.real, eigenvalue.imag))
    if eigenvalue.imag <= 0:
        return 0.0, 0.0, None
    return omega / (2 * np.pi), -2 * eigenvalue.real / omega, modal_a / (2j * eigenvalue.imag) or None


class _Reader:
    """Reads the records of one dataset, in columns or with blanks between."""

    def __init__(self, lines: Sequence[str], index: int) -> None:
        self._lines, self._index = lines, index
        if len(lines) <= UNIVERSAL.shape_records:
            raise refusal(
                f"mode {index} is cut short",
                value=len(lines),
                allowed=bounds(exclusive_minimum=UNIVERSAL.shape_records),
            )

    def integers(self, line: int, count: int) -> list[int]:
        """Return the first whole numbers of a line."""
        fields = self._lines[line].split()
        try:
            return [int(field) for field in (*fields, *["0"] * count)[:count]]
        except ValueError:
            raise self._no_number(self._lines[line]) from None

    def numbers(self, line: int) -> list[float]:
        """Return the numbers of a line."""
        text = self._lines[line]
        if _STRANGE.search(text):
            raise self._no_number(text)
        text = text.translate(_FORTRAN)
        for fields in (text.split(), list(_columns(text))):
            try:
                values = [float(field) for field in fields]
            except ValueError:
                continue
            if all(map(np.isfinite, values)):
                return values
        raise self._no_number(text)

    def nodes(self, count: int) -> tuple[tuple[int, ...], FloatArray]:
        """Return node numbers, and as many values at each."""
        step = 1 + -(-count // UNIVERSAL.numbers_per_row)
        n_nodes, remainder = divmod(len(self._lines) - UNIVERSAL.shape_records, step)
        if remainder or not 1 <= n_nodes <= UNIVERSAL.max_shape_nodes:
            raise refusal(
                f"mode {self._index} is cut short, or has too many nodes",
                value=n_nodes,
                allowed=bounds(1, UNIVERSAL.max_shape_nodes),
            )
        nodes, entries = self._split_at_blanks(n_nodes, count) or self._in_columns(step, count)
        if len(set(nodes)) < len(nodes):
            raise refusal(f"mode {self._index} has a node twice", field="nodes")
        if not np.isfinite(entries).all():
            raise refusal(f"mode {self._index} holds a value that is not finite", field="shape")
        return nodes, entries

    def _split_at_blanks(self, n_nodes: int, count: int) -> tuple[tuple[int, ...], FloatArray] | None:
        """Return nodes and values if blanks separate all numbers (fast path); else None."""
        text = " ".join(self._lines[UNIVERSAL.shape_records :])
        fields = text.translate(_FORTRAN).split()
        if len(fields) != n_nodes * (1 + count) or _STRANGE.search(text):
            return None
        try:
            values = np.array(list(map(float, fields))).reshape(n_nodes, 1 + count)
        except ValueError:
            return None
        return tuple(map(self._node, fields[:: 1 + count])), values[:, 1:]

    def _in_columns(self, step: int, count: int) -> tuple[tuple[int, ...], FloatArray]:
        nodes, entries = [], []
        for start in range(UNIVERSAL.shape_records, len(self._lines), step):
            nodes.append(self._node(self._lines[start].strip()))
            entry = [value for line in range(start + 1, start + step) for value in self.numbers(line)]
            if len(entry) != count:
                raise refusal(
                    f"mode {self._index} has other than {count} values at node {nodes[-1]}",
                    field="shape",
                    value=len(entry),
                    allowed=count,
                )
            entries.append(entry)
        return tuple(nodes), np.array(entries)

    def _node(self, text: str) -> int:
        if not text.isascii() or not text.isdigit() or int(text) > UNIVERSAL.max_node:
            raise self._no_number(text)
        return int(text)

    def _no_number(self, text: str) -> Exception:
        sample = text.strip()[:20]
        return refusal(f"mode {self._index} holds what is no number: {sample!r}", value=sample)


def _columns(text: str) -> Iterator[str]:
    yield from (text[at : at + UNIVERSAL.number_width] for at in range(0, len(text), UNIVERSAL.number_width))

"""FRF blocks of the thesis program's text layout, and their assembly to a measurement."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.file_content import FileContent
from modallab.interchange.settings import FRF_TEXT_FILE, UNIVERSAL
from modallab.interchange.uff_split import refusal

KINDS = (FrfKind.RECEPTANCE, FrfKind.MOBILITY, FrfKind.INERTANCE)  # 1, 2, 3 in a file
_STRANGE = re.compile(r"[^0-9+\-.eEdD \t]")
# Of F7.1, which the program lists frequencies in.
_TOUCHING_LISTED = re.compile(r"(?<=\.[0-9])(?=[0-9]{5}\.[0-9])")
_FORTRAN = str.maketrans("dDe", "EEE")
_FRF_COUNT = re.compile(r"modallab, FRF \d+ of (\d+)")


@dataclass(frozen=True, eq=False)
class FrfBlock:
    """One FRF."""

    kind: FrfKind
    source: Dof
    response: Dof
    freq: FloatArray
    axis_error: float  # relative, of rounding
    values: ComplexArray
    coherence: FloatArray | None
    of: int | None
    """FRFs of the file when it was written; None: not stated."""


def read_blocks(text: str) -> Iterator[FrfBlock]:
    """Yield the FRFs of a file.

    Raises
    ------
    InvalidInputError
        If a block is cut off, or holds other or more numbers than it declares.
    """
    reader = _Reader(text)
    while reader.more():
        if reader.number > FRF_TEXT_FILE.max_blocks:
            raise refusal("the file has too many FRFs", allowed=FRF_TEXT_FILE.max_blocks)
        yield _block(reader)


def assemble(blocks: Sequence[FrfBlock]) -> FileContent:
    """Return the measurement of FRFs of one kind on one axis, one of each response and drive.

    Raises
    ------
    InvalidInputError
        If they are of several kinds or axes, or one is there twice or missing.
    """
    if not blocks:
        raise refusal("the file holds no FRF", allowed="blocks of one FRF each")
    short = [block.of for block in blocks if block.of is not None and block.of != len(blocks)]
    if short:
        raise refusal(f"the file had {short[0]} FRFs and has {len(blocks)}: cut off", value=len(blocks))
    first = blocks[0]
    if any(block.kind is not first.kind for block in blocks):
        raise refusal("the FRFs are of several kinds", field="kind", allowed="one kind")
    if any(not np.array_equal(block.freq, first.freq) for block in blocks):
        raise refusal("the FRFs do not share one frequency axis", field="freq")
    outputs = tuple(dict.fromkeys(block.response for block in blocks))
    inputs = tuple(dict.fromkeys(block.source for block in blocks))
    blocks_by_pair = {(block.response.point, block.source.point): block for block in blocks}
    pairs = [(output.point, source.point) for output in outputs for source in inputs]
    if len(blocks_by_pair) < len(blocks):
        raise refusal("an FRF is in the file twice", field="outputs", value=list(map(str, outputs)))
    if len(set(pairs)) < len(pairs) or set(pairs) != set(blocks_by_pair):
        raise refusal(
            "not every response has an FRF of every drive",
            field="outputs",
            value=len(blocks),
            allowed=len(pairs),
        )
    ordered = [blocks_by_pair[pair] for pair in pairs]
    shape = (-1, len(outputs), len(inputs))
    values = np.stack([block.values for block in ordered], axis=1).reshape(shape)
    coherences = [block.coherence for block in ordered if block.coherence is not None]
    coherence = None
    if len(coherences) == len(ordered):
        coherence = np.stack(coherences, axis=1).reshape(shape)
        coherence = coherence[:, :, 0] if len(inputs) == 1 else coherence
    notes = () if len(coherences) in (0, len(ordered)) else ("coherence left out: not there for every FRF",)
    return FileContent(
        frf=FrfSet(freq=first.freq, values=values, outputs=outputs, inputs=inputs, kind=first.kind),
        coherence=coherence,
        notes=notes,
        axis_error=max(1e-6, first.axis_error),
    )


def _block(reader: "_Reader") -> FrfBlock:
    title = reader.line()
    (kind,) = reader.integers(1)
    count, start, step, step_error = reader.axis()
    (flag,) = reader.integers(1)
    ends = reader.integers(5)
    reader.line()  # five zeros without meaning
    reader.integers(2)  # coordinate numbers of the program
    if not 1 <= kind <= len(KINDS) or flag not in (0, 1):
        raise reader.refusal("has a kind or a coherence flag that does not exist", f"{kind}, {flag}")
    pairs = reader.numbers(2 * count)
    coherence = reader.numbers(count) if flag else None
    listed = reader.numbers(
        count, filled=-(-count // FRF_TEXT_FILE.others_per_row) * FRF_TEXT_FILE.others_per_row
    )
    freq: FloatArray = start + step * np.arange(count, dtype=float)
    # The list has at least one decimal; the error of the step grows with the line number.
    if not (np.abs(listed[:count] - freq) <= 0.06 + step_error * np.arange(count)).all():
        raise reader.refusal("lists other frequencies than start and step give", f"{listed[0]:g}")
    match = _FRF_COUNT.match(title)
    return FrfBlock(
        kind=KINDS[kind - 1],
        source=reader.dof(ends[0], ends[1]),
        response=reader.dof(ends[2], ends[3]),
        freq=freq,
        axis_error=step_error / step if step else 0.0,
        values=pairs[::2] + 1j * pairs[1::2],
        coherence=coherence,
        of=int(match[1]) if match else None,
    )


def _split_columns(row: str) -> str:
    """Return a row with a blank before every minus sign that begins a number."""
    # Not by a regular expression, because this line takes most of the time.
    return row.translate(_FORTRAN).replace("-", " -").replace("E -", "E-")


class _Reader:
    """Reader of lines and numbers, in columns or separated by blanks."""

    def __init__(self, text: str) -> None:
        self._text = text.rstrip()
        self._position = self._line = 0
        self.number = 0  # of the block

    def more(self) -> bool:
        """Return whether another block begins here."""
        self.number += 1
        return self._position < len(self._text)

    def line(self) -> str:
        """Return the next line."""
        if not self._position < len(self._text):
            raise self.refusal("is cut off")
        begin, end = self._position, self._text.find("\n", self._position)
        end = len(self._text) if end < 0 else end
        self._position = end + 1
        self._line += 1
        return self._text[begin:end].rstrip()

    def integers(self, count: int) -> list[int]:
        """Return the whole numbers of the next line."""
        text = self.line()
        fields = text.split()
        if len(fields) != count:
            raise self.refusal(f"has other than {count} whole numbers in a line", text)
        try:
            return [int(field) for field in fields]
        except ValueError:
            raise self.refusal("holds what is no whole number", text) from None

    def axis(self) -> tuple[int, float, float, float]:
        """Return count, start and step in Hz, and the rounding error of the step."""
        text = self.line()
        fields = text.split()
        if len(fields) != 3 or not fields[0].isdecimal() or len(fields[0]) > 9:
            raise self.refusal("does not say count, start and step of its frequencies", text)
        count = int(fields[0])
        if not 1 <= count <= UNIVERSAL.max_lines:
            raise self.refusal("declares too many frequencies, or none", str(count))
        start, step = self._parsed(" ".join(fields[1:]), 2)
        if not (0 <= start <= FRF_TEXT_FILE.max_frequency and 0 < step <= FRF_TEXT_FILE.max_frequency):
            raise self.refusal("has frequencies that do not rise from 0 Hz or above", text)
        mantissa, _, exponent = fields[2].translate(_FORTRAN).partition("E")
        digits = len(mantissa.partition(".")[2]) - int(exponent or 0)
        return count, start, step, 0.5 * 10.0 ** -min(max(digits, -9), 20)

    def numbers(self, count: int, filled: int = 0) -> FloatArray:
        """Return `count` numbers from the next lines, padded to at most `filled`."""
        rows, n_read = [], 0
        while n_read < count:
            row = self.line()
            fields = row.split()
            if row.count(".") > len(fields):  # columns touch
                row = _TOUCHING_LISTED.sub(" ", row) if filled else _split_columns(row)
                fields = row.split()
            rows.append(row)
            n_read += len(fields)
            if len(rows) > count:
                raise self.refusal("has empty lines")
        if n_read > max(count, filled):
            raise self.refusal("has other numbers in a line than it declares", rows[-1])
        return self._parsed(" ".join(rows), n_read)

    def _parsed(self, text: str, count: int) -> FloatArray:
        strange = _STRANGE.search(text)
        if strange:
            raise self.refusal("holds what is no number", text[max(0, strange.start() - 8) :])
        try:
            values = np.array(list(map(float, text.translate(_FORTRAN).split())))
        except ValueError:
            raise self.refusal("holds what is no number", text) from None
        if len(values) != count or not np.isfinite(values).all():
            raise self.refusal("holds a value that is not finite", text)
        return values

    def dof(self, node: int, direction: int) -> Dof:
        """Return a DoF from its node and the number of its direction."""
        if not 0 <= node <= FRF_TEXT_FILE.max_node or not 1 <= abs(direction) <= len(DIRECTIONS):
            raise self.refusal("has a coordinate that does not exist", f"{node}, {direction}")
        return Dof(node, DIRECTIONS[abs(direction) - 1], 1 if direction > 0 else -1)

    def refusal(self, problem: str, text: str = "") -> Exception:
        """Return the error of this block."""
        sample = " ".join(text.split())[:30].encode("ascii", "replace").decode()
        return refusal(f"FRF {self.number} of the file {problem}", value=sample, line=self._line)

"""Dataset 58 by dataset 58: sizes checked against the file first, then read by pyuff."""

import re
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyuff
from numpy.typing import NDArray

from modallab.core.errors import InvalidInputError
from modallab.interchange.uff_text import program_of

LARGEST = 24_000_000  # bytes of a file: 100 responses of 3,201 lines with all spectra take 13 million
MOST_LINES = 100_000  # of one function
MOST_SETS = 6_000
FUNCTION, UNITS, HEADER = 58, 164, 151

_OPEN = re.compile(rb"    -1 *\r?\n")
_CLOSE = re.compile(rb"\n    -1 *\r?(?:\n|\Z)")
_CLOSE_BINARY = re.compile(rb"[\r\n]*    -1 *\r?(?:\n|\Z)")
_BLANK = re.compile(rb"\s*")
_LONGEST_HEADER = 400  # bytes of a line; 80 characters by the format, some write more
_LONGEST_ROW = 100  # bytes of a line of numbers
_HEADER_LINES = 12
SMALL = 1_000  # bytes that header and units may have; larger ones pass by
_CONTROL = bytes(range(32)) + b"\x7f"
_HEADER = bytes.maketrans(_CONTROL, b" " * len(_CONTROL))
_FORTRAN = bytes.maketrans(b"dD", b"EE")
_OF_NUMBERS = b"0123456789+-.eE \r\n"


@dataclass(frozen=True)
class _Form:
    """How a function's numbers are laid down."""

    binary: bool
    double: bool
    complex: bool
    uneven: bool
    count: int

    @property
    def n_values(self) -> int:
        return self.count * (1 + self.complex + self.uneven)

    @property
    def n_bytes(self) -> int:
        return self.n_values * (8 if self.double else 4)

    @property
    def n_rows(self) -> int:
        if not self.double:
            return -(-self.n_values // 6)
        if not self.uneven:
            return -(-self.n_values // 4)
        return self.count if self.complex else -(-self.count // 2)


def refusal(message: str, **context: str | float) -> InvalidInputError:
    """Return the error of a file that cannot be read."""
    return InvalidInputError(message, **{"field": "file", **context})


def starts(payload: bytes) -> bool:
    """Return whether a file begins as universal files do."""
    first = _BLANK.match(payload).end()  # type: ignore[union-attr]
    return payload[first : first + 2] == b"-1"


def read_sets(payload: bytes, largest: int) -> Iterator[dict[str, Any]]:
    """Yield header (151: `program`), units (164: `length, force`) and functions (58: as pyuff has them).

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is cut off, or declares more or other numbers than it holds.
    """
    counts = []
    # pyuff works on paths only
    with tempfile.TemporaryDirectory(prefix="modallab-") as folder:
        path = Path(folder) / "tidy.uff"
        with path.open("wb") as file:
            for number, text, count in _split(_limited(payload, largest), {UNITS: SMALL, HEADER: SMALL}):
                # Not by pyuff: it refuses headers with lines missing, of which no harm comes.
                if number == HEADER:
                    yield {"type": HEADER, "program": program_of(text.decode("ascii", "replace"))}
                elif number == UNITS:
                    length, force = factors(text.decode("ascii", "replace"))
                    yield {"type": UNITS, "length": length, "force": force}
                else:
                    file.write(text)
                    counts.append(count)
        try:
            reader = pyuff.UFF(str(path))
        except Exception as error:  # pyuff raises nothing narrower
            raise refusal(f"the file cannot be read: {error}") from None
        if reader.get_n_sets() != len(counts):
            raise refusal("the marks between the datasets are not clear")
        for index, count in enumerate(counts):
            yield _parsed(reader, index, count)


def read_texts(payload: bytes, largest: int, wanted: Mapping[int, int]) -> Iterator[tuple[int, str]]:
    """Yield the number and the lines of text datasets, without mark and number.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.
    wanted
        The datasets' numbers, and the bytes beyond which each passes by.

    Raises
    ------
    InvalidInputError
        If it is no universal file, or is cut off.
    """
    for number, text, _ in _split(_limited(payload, largest), wanted):
        if number in wanted:
            yield number, text.decode("ascii", "replace")


def factors(units: str) -> tuple[float, float]:
    """Return by what lengths and forces are divided to be in SI, from the text of dataset 164.

    Raises
    ------
    InvalidInputError
        If they are missing, or of a size that no unit has.
    """
    fields = " ".join(units.upper().replace("D", "E").split("\n")[1:]).split()[:2]
    try:
        length, force = (float(field) for field in fields)
    except ValueError:
        raise refusal("the file's units (164) cannot be read", value=" ".join(fields)[:40]) from None
    if not (1e-12 < length < 1e12 and 1e-12 < force < 1e12):  # NaN fails too
        raise refusal("the file's units (164) are out of bounds", value=f"{length:g}, {force:g}")
    return length, force


def _limited(payload: bytes, largest: int) -> bytes:
    limit = min(largest, LARGEST)
    if len(payload) > limit:
        raise refusal(f"the universal file is larger than {limit} bytes", allowed=limit)
    return payload


def _parsed(reader: Any, index: int, count: int) -> dict[str, Any]:
    try:
        with np.errstate(all="ignore"):
            dataset: dict[str, Any] = reader.read_sets(index)
    except Exception as error:  # pyuff raises nothing narrower
        raise refusal(f"dataset {index + 1} cannot be read: {error}", dataset=index + 1) from None
    if dataset["type"] != FUNCTION:
        raise refusal(f"dataset {index + 1} cannot be read", dataset=index + 1)
    x, data = np.asarray(dataset["x"]), np.asarray(dataset["data"])
    if len(x) != count or len(data) != count:
        raise refusal(
            f"dataset {index + 1} holds another number of values than it declares",
            dataset=index + 1,
            value=len(data),
            allowed=count,
        )
    _check_finite(data, index)
    _check_finite(x, index)
    return dataset


def _check_finite(values: NDArray[Any], index: int) -> None:
    if not np.isfinite(values).all():
        raise refusal(f"dataset {index + 1} holds a value that is not finite", dataset=index + 1)


def _split(payload: bytes, wanted: Mapping[int, int]) -> Iterator[tuple[int, bytes, int]]:
    """Yield a dataset's number, text, and how many values it declares.

    Functions come with marks, tidied for pyuff; wanted text datasets as lines after the number.
    """
    position = 0
    for index in range(MOST_SETS + 1):
        text = _BLANK.match(payload, position).end()  # type: ignore[union-attr]
        if text == len(payload):
            return
        position = max(position, payload.rfind(b"\n", position, text) + 1)
        opening = _OPEN.match(payload, position)
        if opening is None:
            raise refusal(f"dataset {index + 1} does not begin with its mark, `-1`", dataset=index + 1)
        begin = opening.end()
        field = payload[begin : begin + 6].strip()
        if not field.isdigit():
            raise refusal(f"dataset {index + 1} has no number", dataset=index + 1)
        number = int(field)
        if number == FUNCTION:
            tidy, count, position = _function(payload, begin, index)
            yield number, tidy, count
            continue
        closing = _CLOSE.search(payload, begin)
        if closing is None:
            raise _cut_off(index)
        position, end = closing.end(), closing.start() + 1
        if end - begin < wanted.get(number, 0):
            first = payload.find(b"\n", begin, end) + 1
            yield number, payload[first:end], 0
    raise refusal("the file has too many datasets", allowed=MOST_SETS)


def _cut_off(index: int) -> InvalidInputError:
    return refusal(f"the file ends within dataset {index + 1}", dataset=index + 1)


def _function(payload: bytes, begin: int, index: int) -> tuple[bytes, int, int]:
    """Return a function tidied for pyuff, how many values it declares, and where it ends."""
    lines = []
    for _ in range(_HEADER_LINES):
        stop = payload.find(b"\n", begin, begin + _LONGEST_HEADER)
        if stop < 0:
            raise _cut_off(index)
        lines.append(payload[begin:stop].translate(_HEADER).rstrip())
        begin = stop + 1
    # pyuff takes any line that ends so for a mark
    lines[1:6] = [line.replace(b"    -1", b"   -1") for line in lines[1:6]]
    form = _form(lines, index)
    data, position = (_bytes if form.binary else _rows)(payload, begin, form, index)
    return b"\n".join([b"    -1", *lines, data]) + b"    -1\n", form.count, position


def _form(lines: list[bytes], index: int) -> _Form:
    record = lines[7]
    try:
        kind, count, spacing = (int(record[at : at + 10]) for at in (0, 10, 20))
    except ValueError:
        raise refusal(f"dataset {index + 1} does not say how many values it has", dataset=index + 1) from None
    if kind not in (2, 4, 5, 6) or spacing not in (0, 1):
        raise refusal(f"dataset {index + 1} has a data form that does not exist", dataset=index + 1)
    if not 1 <= count <= MOST_LINES:
        raise refusal(
            f"dataset {index + 1} declares {count} values",
            dataset=index + 1,
            value=count,
            allowed=f"1 to {MOST_LINES}",
        )
    binary = lines[0][6:7] in (b"b", b"B")
    if binary and lines[0][13:19].strip() != b"2":
        raise refusal(f"dataset {index + 1} has floating-point numbers other than IEEE", dataset=index + 1)
    return _Form(binary, double=kind in (4, 6), complex=kind in (5, 6), uneven=spacing == 0, count=count)


def _bytes(payload: bytes, begin: int, form: _Form, index: int) -> tuple[bytes, int]:
    end = begin + form.n_bytes
    closing = _CLOSE_BINARY.match(payload, end) if end <= len(payload) else None
    if closing is None:
        raise refusal(
            f"dataset {index + 1} holds other than the {form.n_bytes} bytes it declares, or is cut off",
            dataset=index + 1,
            value=min(len(payload) - begin, form.n_bytes),
            allowed=form.n_bytes,
        )
    return payload[begin:end], closing.end()


def _rows(payload: bytes, begin: int, form: _Form, index: int) -> tuple[bytes, int]:
    closing = _CLOSE.search(payload, begin - 1)
    if closing is None:
        raise _cut_off(index)
    size = closing.start() - begin
    if size > _LONGEST_ROW * form.n_rows:
        raise refusal(f"dataset {index + 1} is longer than it declares", dataset=index + 1, value=size)
    text = payload[begin : closing.start() + 1].translate(_FORTRAN)
    strange = text.translate(None, _OF_NUMBERS)
    if strange:
        raise refusal(
            f"dataset {index + 1} holds what is no number: {strange[:20].decode('ascii', 'replace')!r}",
            dataset=index + 1,
            allowed="numbers in columns, without separators",
        )
    rows = [row.rstrip() for row in text.rstrip().split(b"\n")]
    if len(rows) != form.n_rows:
        raise refusal(
            f"dataset {index + 1} has another number of lines than it declares",
            dataset=index + 1,
            value=len(rows),
            allowed=form.n_rows,
        )
    return b"\n".join(rows) + b"\n", closing.end()

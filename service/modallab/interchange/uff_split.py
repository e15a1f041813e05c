"""Division of a universal file into datasets; declared sizes are checked against the file."""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError, JsonValue, bounds
from modallab.interchange.settings import UNIVERSAL

FUNCTION = 58

_OPEN = re.compile(rb"    -1 *\r?\n")
_CLOSE = re.compile(rb"\n    -1 *\r?(?:\n|\Z)")
_CLOSE_BINARY = re.compile(rb"[\r\n]*    -1 *\r?(?:\n|\Z)")
_BLANK = re.compile(rb"\s*")
_CONTROL = bytes(range(32)) + b"\x7f"
_HEADER = bytes.maketrans(_CONTROL, b" " * len(_CONTROL))
_FORTRAN = bytes.maketrans(b"dD", b"EE")
_OF_NUMBERS = b"0123456789+-.eE \r\n"


@dataclass(frozen=True)
class Dataset:
    """Dataset: number and, unless it is ignored, its text and number of declared values."""

    number: int
    kind: int | None = None  # a function's type
    text: bytes | None = None  # a function with marks, tidied for pyuff; another dataset after its number
    count: int = 0


@dataclass(frozen=True)
class _Form:
    """Storage format of a function's numbers."""

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


def refusal(message: str, **context: JsonValue) -> InvalidInputError:
    """Return the error of a file that cannot be read."""
    return InvalidInputError(message, **({"field": "file"} | context))


def starts(payload: bytes) -> bool:
    """Return whether a file begins as universal files do."""
    first = _BLANK.match(payload).end()  # type: ignore[union-attr]
    return payload[first : first + 2] == b"-1"


def split(payload: bytes, text_limits: Mapping[int, int], kinds: Collection[int]) -> Iterator[Dataset]:
    """Yield every dataset; those not requested have no text, whatever their size.

    Parameters
    ----------
    text_limits
        Numbers of text datasets, and the bytes beyond which each passes by.
    kinds
        Types of the functions (dataset 58) wanted.

    Raises
    ------
    InvalidInputError
        If the file is no universal file, is cut off, or a function declares other numbers than it holds.
    """
    position = 0
    for index in range(UNIVERSAL.max_datasets + 1):
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
            dataset, position = _function(payload, begin, kinds, index)
            yield dataset
            continue
        end, position = _text(payload, begin, index)
        if end - begin < text_limits.get(number, 0):
            first = payload.find(b"\n", begin, end) + 1
            yield Dataset(number, text=payload[first:end])
        else:
            yield Dataset(number)
    raise refusal("the file has too many datasets", allowed=UNIVERSAL.max_datasets)


def _text(payload: bytes, begin: int, index: int) -> tuple[int, int]:
    """Return where a text dataset's last line ends, and where the next dataset begins."""
    closing = _CLOSE.search(payload, begin - 1)
    if closing is None:
        raise _cut_off(index)
    return closing.start() + 1, closing.end()


def _cut_off(index: int) -> InvalidInputError:
    return refusal(f"the file ends within dataset {index + 1}", dataset=index + 1)


def _function(payload: bytes, begin: int, kinds: Collection[int], index: int) -> tuple[Dataset, int]:
    """Return a function, and where the next dataset begins."""
    lines = []
    for _ in range(UNIVERSAL.header_lines):
        stop = payload.find(b"\n", begin, begin + UNIVERSAL.max_header_bytes)
        if stop < 0:
            raise _cut_off(index)
        lines.append(payload[begin:stop].translate(_HEADER).rstrip())
        begin = stop + 1
    # pyuff takes any line that ends so for a mark
    lines[1:6] = [line.replace(b"    -1", b"   -1") for line in lines[1:6]]
    field = lines[6][:5].strip()
    kind = int(field) if field.isdigit() else None
    form = _form(lines, index)
    if kind is not None and kind not in kinds:
        position = _closed(payload, begin, form, index) if form.binary else _text(payload, begin, index)[1]
        return Dataset(FUNCTION, kind), position
    if not 1 <= form.count <= UNIVERSAL.max_lines:
        raise refusal(
            f"dataset {index + 1} declares {form.count} values",
            dataset=index + 1,
            value=form.count,
            allowed=bounds(1, UNIVERSAL.max_lines),
        )
    data, position = (_bytes if form.binary else _rows)(payload, begin, form, index)
    tidy = b"\n".join([b"    -1", *lines, data]) + b"    -1\n"
    return Dataset(FUNCTION, kind, tidy, form.count), position


def _form(lines: list[bytes], index: int) -> _Form:
    record = lines[7]
    try:
        kind, count, spacing = (int(record[at : at + 10]) for at in (0, 10, 20))
    except ValueError:
        raise refusal(f"dataset {index + 1} does not say how many values it has", dataset=index + 1) from None
    if kind not in (2, 4, 5, 6) or spacing not in (0, 1):
        raise refusal(f"dataset {index + 1} has a data form that does not exist", dataset=index + 1)
    if count < 0:
        raise refusal(f"dataset {index + 1} declares {count} values", dataset=index + 1, value=count)
    binary = lines[0][6:7] in (b"b", b"B")
    if binary and lines[0][13:19].strip() != b"2":
        raise refusal(f"dataset {index + 1} has floating-point numbers other than IEEE", dataset=index + 1)
    return _Form(binary, double=kind in (4, 6), complex=kind in (5, 6), uneven=spacing == 0, count=count)


def _bytes(payload: bytes, begin: int, form: _Form, index: int) -> tuple[bytes, int]:
    position = _closed(payload, begin, form, index)
    return payload[begin : begin + form.n_bytes], position


def _closed(payload: bytes, begin: int, form: _Form, index: int) -> int:
    """Return where the dataset after a binary one begins."""
    end = begin + form.n_bytes
    closing = _CLOSE_BINARY.match(payload, end) if end <= len(payload) else None
    if closing is None:
        raise refusal(
            f"dataset {index + 1} holds other than the {form.n_bytes} bytes it declares, or is cut off",
            dataset=index + 1,
            value=min(len(payload) - begin, form.n_bytes),
            allowed=form.n_bytes,
        )
    return closing.end()


def _rows(payload: bytes, begin: int, form: _Form, index: int) -> tuple[bytes, int]:
    closing = _CLOSE.search(payload, begin - 1)
    if closing is None:
        raise _cut_off(index)
    size = closing.start() - begin
    if size > UNIVERSAL.max_row_bytes * form.n_rows:
        raise refusal(f"dataset {index + 1} is longer than it declares", dataset=index + 1, value=size)
    text = payload[begin : closing.start() + 1].translate(_FORTRAN)
    strange = text.translate(None, _OF_NUMBERS)
    if strange:
        row = text.count(b"\n", 0, text.index(strange[:1])) + 1
        sample = strange[:20].decode("ascii", "replace")
        raise refusal(
            f"dataset {index + 1} holds what is no number, in row {row} of its values: {sample!r}",
            dataset=index + 1,
            row=row,
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

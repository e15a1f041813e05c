"""Matrices of OUTPUT4 files, as text or in binary, dense or sparse.

Not by pyNastran, for what `deck` says of it, nor by pyyeti, which brings numba, pandas and matplotlib along
and makes room for any matrix that a header claims to be there.
"""

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from typing import NoReturn, Protocol

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.interchange.settings import MODEL_FILE

SQUARE, SYMMETRIC = 1, 6  # forms that are stored entry by entry
SINGLE, DOUBLE = 1, 2  # types of real numbers
_FORMAT = re.compile(r"([0-9]{1,2})[ED]([0-9]{1,2})\.", re.I)


@dataclass(frozen=True)
class _Header:
    columns: int
    rows: int  # below zero: sparse, with strings as of many rows
    form: int
    type: int
    name: str


class _Tape(Protocol):
    """Sequential reader of headers, columns and numbers."""

    def header(self) -> _Header | None:
        """Return the header of the next matrix; None after the last."""
        ...

    def column(self) -> tuple[int, int, int]:
        """Return the next column's number, its first row, 0 of a sparse one, and its words."""
        ...

    def wholes(self, count: int) -> list[int]:
        """Return whole numbers."""
        ...

    def reals(self, words: int, *, dense: bool = False) -> FloatArray:
        """Return as many reals as take so many words."""
        ...

    def end(self) -> None:
        """Pass over the number in the column that ends a matrix."""
        ...


def read_op4(payload: bytes, *, size: int, path: str = "file") -> dict[str, csc_array]:
    """Return the matrices of an OUTPUT4 file by their names in capitals.

    Parameters
    ----------
    payload
        The file.
    size
        Rows and columns that each must have.
    path
        What errors call the file.

    Raises
    ------
    InvalidInputError
        If it is no such file, is damaged, or a matrix is complex, of another size or form, or there twice.
    """
    matrices: dict[str, csc_array] = {}
    try:
        tape = _Binary(payload) if _order(payload) else _Text(payload)
        while header := tape.header():
            _check(header, size, path)
            if header.name in matrices:
                _refuse(path, f"matrix {header.name} is there twice", header.name)
            matrices[header.name] = _matrix(header, tape, path)
    except InvalidInputError:
        raise
    # What is cut off, or no such file, fails where a number is taken from it.
    except (ValueError, IndexError, struct.error) as error:
        raise InvalidInputError(
            f"{path} is no OUTPUT4 file: {error}", field=path, allowed="an OUTPUT4 file"
        ) from None
    if not matrices:
        _refuse(path, "it holds no matrix", 0)
    return matrices


def _refuse(
    path: str, problem: str, value: object, requirement: str = "real square matrices, each once"
) -> NoReturn:
    raise InvalidInputError(f"{path}: {problem}", field=path, value=str(value), allowed=requirement)


def _check(header: _Header, size: int, path: str) -> None:
    name = header.name
    if (abs(header.rows), header.columns) != (size, size):
        shape = f"{abs(header.rows)} x {header.columns}"
        _refuse(path, f"matrix {name} does not fit the degrees of freedom", shape, f"{size} x {size}")
    if header.type not in (SINGLE, DOUBLE):
        _refuse(path, f"matrix {name} is complex", f"type {header.type}", "types 1 and 2: real")
    if header.form not in (SQUARE, SYMMETRIC):
        _refuse(path, f"matrix {name} has form {header.form}", header.form, "1: square, 6: symmetric")


def _matrix(header: _Header, tape: _Tape, path: str) -> csc_array:
    size = header.columns
    strings = [
        (row, column, values)
        for column, first, words in _columns(header, tape)
        for row, values in _strings(header, tape, first, words)
    ]
    if not strings:
        return csc_array((size, size))
    row, column = np.array([position for *position, _ in strings]).T
    lengths = np.array([len(values) for *_, values in strings])
    if row.min() < 1 or (row + lengths).max() > size + 1:
        _refuse(path, f"matrix {header.name} has entries beyond its rows", int((row + lengths).max() - 1))
    within = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    numbers = np.concatenate([values for *_, values in strings])
    rows, columns = np.repeat(row - 1, lengths) + within, np.repeat(column - 1, lengths)
    matrix = csc_array((numbers, (rows, columns)), shape=(size, size))
    if matrix.nnz < len(numbers) or not np.isfinite(numbers).all():
        _refuse(path, f"matrix {header.name} has an entry twice, or one that is not finite", header.name)
    matrix.eliminate_zeros()
    return matrix


def _columns(header: _Header, tape: _Tape) -> Iterator[tuple[int, int, int]]:
    """Yield columns up to the extra one that ends a matrix."""
    while (column := tape.column())[0] <= header.columns:
        if column[0] < 1:
            raise ValueError(f"there is no column {column[0]}")
        yield column
    tape.end()


def _strings(header: _Header, tape: _Tape, first: int, words: int) -> Iterator[tuple[int, FloatArray]]:
    """Yield the numbers of a column that stand below one another, with the row of the first."""
    if first > 0:
        yield first, tape.reals(words, dense=True)
        return
    while words > 0:
        if header.rows < 0 or header.rows >= MODEL_FILE.large_matrix_rows:
            length, row = tape.wholes(2)
            words -= 1
        else:
            (packed,) = tape.wholes(1)
            length, row = packed >> 16, packed & 0xFFFF
        words -= length
        yield row, tape.reals(length - 1)


class _Text:
    """Text files: integers in eight columns, reals in the format of the header."""

    def __init__(self, payload: bytes) -> None:
        self._lines, self._at = payload.decode("ascii").splitlines(), 0
        self._per_line, self._width, self._words = 5, 16, 1

    def header(self) -> _Header | None:
        if not any(line.strip() for line in self._lines[self._at : self._at + 1]):
            return None
        line = self._line().rstrip()
        columns, rows, form, kind = (int(line[at : at + 8]) for at in range(0, 32, 8))
        self._per_line, self._width, self._words = 5, 16, 2 if kind % 2 == 0 else 1
        if number_format := _FORMAT.search(line[40:]):
            self._per_line, self._width = int(number_format[1]), int(number_format[2])
        return _Header(columns, rows, form, kind, line[32:40].strip().upper())

    def column(self) -> tuple[int, int, int]:
        number, first, words = self.wholes(3)
        return number, first, words

    def wholes(self, count: int) -> list[int]:
        line = self._line()
        if count == 1:
            return [int(line)]  # packed, and wider than eight digits
        return [int(line[at : at + 8]) for at in range(0, 8 * count, 8)]

    def reals(self, words: int, *, dense: bool = False) -> FloatArray:
        count = words if dense else words // self._words  # a dense column counts numbers
        candidates = self._lines[self._at : self._at + max(-(-count // self._per_line), 0)]
        lines = [line.rstrip() for line in takewhile(lambda line: "." in line, candidates)]
        text = "".join(lines).upper().replace("D", "E")
        n = len(text) // self._width
        if n < 1 or n != count:
            raise ValueError(f"{count} numbers should follow line {self._at}")
        self._at += len(lines)
        return np.array([float(text[i * self._width : (i + 1) * self._width]) for i in range(n)])

    def end(self) -> None:
        self._line()

    def _line(self) -> str:
        self._at += 1
        return self._lines[self._at - 1]


class _Binary:
    """Binary files: FORTRAN records between their lengths; integers of four or eight bytes."""

    def __init__(self, payload: bytes) -> None:
        self._bytes, self._at, self._record, self._within = payload, 0, b"", 0
        self._order = _order(payload)
        self._whole = "q" if len(self._next()) == 48 else "i"
        self._at = 0
        self._real, self._words = f"{self._order}f8", 1

    def header(self) -> _Header | None:
        if self._at == len(self._bytes):
            return None
        self._record, self._within = self._next(), 0
        columns, rows, form, kind = self.wholes(4)
        wide = self._whole == "q"
        self._real = f"{self._order}f{4 if kind % 2 and not wide else 8}"
        self._words = 1 if kind % 2 or wide else 2
        name = self._record[self._within :].decode("ascii").replace("\0", " ").strip().upper()
        return _Header(columns, rows, form, kind, name)

    def column(self) -> tuple[int, int, int]:
        self._record, self._within = self._next(), 0
        number, first, words = self.wholes(3)
        return number, first, words

    def wholes(self, count: int) -> list[int]:
        layout = struct.Struct(f"{self._order}{count}{self._whole}")
        integers = layout.unpack_from(self._record, self._within)
        self._within += layout.size
        return list(integers)

    def reals(self, words: int, *, dense: bool = False) -> FloatArray:
        count = words // self._words
        if count < 1:
            raise ValueError(f"a string of {count} numbers")
        numbers = np.frombuffer(self._record, self._real, count, self._within)
        self._within += numbers.nbytes
        return numbers.astype(float)

    def end(self) -> None:
        pass  # the record of the column holds it

    def _next(self) -> bytes:
        """Return the record that begins where the last one ended."""
        marker = struct.Struct(f"{self._order}i")
        (length,) = marker.unpack_from(self._bytes, self._at)
        first = self._at + marker.size
        (again,) = marker.unpack_from(self._bytes, first + length)
        if length < 1 or again != length:
            raise ValueError(f"the record at byte {self._at} has no end")
        self._at = first + length + marker.size
        return self._bytes[first : first + length]


def _order(payload: bytes) -> str:
    """Return the order of a binary file's bytes, nothing of one that is text."""
    for order in "<>":
        if payload[:4] in (struct.pack(f"{order}i", 24), struct.pack(f"{order}i", 48)):
            return order
    return ""

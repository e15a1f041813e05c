"""Numbers in columns of delimited text, whatever separates them, with decimal point or comma."""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import InvalidInputError, JsonValue
from modallab.interchange.settings import TABLE

_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?"
_FIELD = re.compile(rf"\(?{_NUMBER}(?:{_NUMBER}[ij])?\)?", re.ASCII)
_COMPLEX = re.compile(r"[ij]\)?\s*$")
_NOT_FINITE = re.compile(r"(?i)[+-]?(nan|inf|infinity)|#\S*|-{2,}|n/?a")
_COMMENT = "#%*;\"'/! \t"


@dataclass(frozen=True)
class _Dialect:
    """Separator of columns, None for blanks, and decimal sign."""

    separator: str | None
    decimal: str

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line."""
        if self.separator is None:
            return line.split()
        fields = [field.strip().strip('"') for field in line.rstrip("\r\n").split(self.separator)]
        while fields and not fields[-1]:  # many programs end a line with a separator
            fields.pop()
        return fields

    def is_row(self, line: str) -> bool:
        """Return whether a line holds two numbers or more, and nothing else."""
        fields = self.fields(line.replace(self.decimal, ".") if self.decimal != "." else line)
        return len(fields) > 1 and all(_FIELD.fullmatch(field) for field in fields)


_DIALECTS = tuple(_Dialect(*pair) for pair in (("\t", "."), ("\t", ","), (";", ","), (";", "."), (",", ".")))
_BLANKS = (_Dialect(None, "."), _Dialect(None, ","))


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers with their names."""

    names: tuple[str, ...]
    """Names of the columns; empty where the header has none."""
    columns: NDArray[Any]
    """(n_rows, n_columns) real or complex numbers."""
    header: tuple[str, ...]
    """Lines above the numbers."""


def read_table(content: bytes) -> Table:
    """Return the columns of numbers of a text.

    Raises
    ------
    InvalidInputError
        If it holds none, a line has other columns than the first, or a number is missing.
    """
    text = _text(content)
    lines = text.splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    dialect, first = _dialect(lines)
    rows = lines[first:]
    n_columns = len(dialect.fields(rows[0]))
    _check_rows(rows, first, dialect, n_columns)
    return Table(
        _names(lines[:first], dialect, n_columns), _numbers(rows, first, dialect), tuple(lines[:first])
    )


def _text(content: bytes) -> str:
    coding = next((coding for bom, coding in _BOMS if content.startswith(bom)), "utf-8")
    try:
        return content.decode(coding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if "\0" in text[: TABLE.max_header_characters]:
        raise _refusal("the file is no text")
    return text


def _dialect(lines: Sequence[str]) -> tuple[_Dialect, int]:
    """Return the dialect, and the first line, of the first run of rows."""
    best: tuple[int, _Dialect, int] | None = None
    for dialect in (*_DIALECTS, *_BLANKS):
        run = _first_run(lines, dialect)
        if run is not None and (best is None or run[1] > best[0]):
            best = run[1], dialect, run[0]
    if best is None:
        raise _refusal("the file holds no rows of numbers", allowed="columns of numbers, two rows or more")
    return best[1], best[2]


def _first_run(lines: Sequence[str], dialect: _Dialect) -> tuple[int, int] | None:
    """Return start and length of the first rows with equal columns, two or more; few lines are examined."""
    begin, n_columns = 0, 0
    for index, line in enumerate(lines[: TABLE.max_header_lines]):
        count = len(dialect.fields(line)) if dialect.is_row(line) else 0
        if count and count == n_columns:
            if index - begin + 1 >= TABLE.min_rows:
                return begin, index - begin + 1 + _length(lines[index + 1 :], dialect, n_columns)
            continue
        begin, n_columns = index, count
    return None


def _length(lines: Sequence[str], dialect: _Dialect, n_columns: int) -> int:
    """Return the number of rows that follow; few lines are examined."""
    looked = lines[: TABLE.rows_looked_at]
    return sum(dialect.is_row(line) and len(dialect.fields(line)) == n_columns for line in looked)


def _check_rows(rows: Sequence[str], first: int, dialect: _Dialect, n_columns: int) -> None:
    """Raise if a line is empty, or has other columns than the first."""
    for index, row in enumerate(rows):
        n_fields = len(dialect.fields(row))
        if n_fields != n_columns:
            raise _refusal(
                f"line {first + index + 1} has {n_fields} columns, not {n_columns}: cut off, or a new table",
                value=row[:40],
                allowed=n_columns,
                line=first + index + 1,
            )


def _numbers(rows: Sequence[str], first: int, dialect: _Dialect) -> NDArray[Any]:
    body = "\n".join(rows)
    if dialect.separator is not None:
        body = re.sub(rf"[{dialect.separator} ]+$", "", body, flags=re.MULTILINE)
    body = body.replace(",", ".") if dialect.decimal == "," else body
    is_complex = _COMPLEX.search(rows[0]) is not None or any(map(_COMPLEX.search, dialect.fields(rows[0])))
    body = body.replace("i", "j") if is_complex else body
    if "D" in body or "d" in body:
        body = body.replace("D", "E").replace("d", "e")
    try:
        numbers = np.loadtxt(
            io.StringIO(body),
            dtype=complex if is_complex else float,
            delimiter=dialect.separator,
            comments=None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError as error:
        raise _no_number(rows, first, dialect, str(error)) from None
    bad = np.argwhere(~np.isfinite(numbers))
    if len(bad):
        row, column = bad[0].tolist()
        raise _refusal(
            f"line {first + row + 1}, column {column + 1} is not finite",
            value=dialect.fields(rows[row])[column][:40],
            line=first + row + 1,
        )
    return numbers


def _no_number(rows: Sequence[str], first: int, dialect: _Dialect, reason: str) -> InvalidInputError:
    """Return the error of the first field that is no number."""
    for index, row in enumerate(rows):
        for column, field in enumerate(dialect.fields(row), 1):
            text = field.replace(",", ".") if dialect.decimal == "," else field
            if _FIELD.fullmatch(text) is None:
                line = first + index + 1
                return _refusal(
                    f"line {line}, column {column} is no number",
                    value=field[:40],
                    allowed="a number",
                    line=line,
                )
    return _refusal(f"the table cannot be read: {reason[:100]}")


def _names(header: Sequence[str], dialect: _Dialect, n_columns: int) -> tuple[str, ...]:
    """Return the names of the columns: the last line of the header with as many fields, and text in all.

    A line of units below the names is appended to them.
    """
    found: list[list[str]] = []
    for line in reversed(header):
        fields = dialect.fields(line.strip().lstrip(_COMMENT))
        if len(fields) == n_columns and not any(_FIELD.fullmatch(field) for field in fields):
            found.append(fields)
        elif found:
            break
    if not found:
        return ()
    names = found[-1] if len(found) == TABLE.name_lines else found[0]
    units = found[0] if len(found) == TABLE.name_lines else [""] * n_columns
    return tuple(f"{name} {unit}".strip() for name, unit in zip(names, units, strict=True))


def _refusal(message: str, **context: JsonValue) -> InvalidInputError:
    return InvalidInputError(message, **({"field": "file"} | context))

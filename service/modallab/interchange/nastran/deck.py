"""Bulk data as cards: small, large and free fields, continued lines.

Not by pyNastran: its last release, 1.4.1 of 2024, does not import under numpy 2, which it forbids, and its
reader opens other files by name as an uploaded one tells it to.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*")
_REAL = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[eEdD]?([+-][0-9]+)|[eEdD]([0-9]+))?")
_MATRIX = re.compile(r"\s*([ABKM]4?2(?:GG|PP))\s*=\s*(.+)", re.I)  # case control's direct input
_INTEGER = re.compile(r"[+-]?[0-9]{1,10}")


@dataclass(frozen=True)
class Card:
    """Card with its name and fields; the first one is field 2 of the quick reference guide."""

    name: str
    fields: tuple[str, ...]
    line: int  # of the file, from 1

    def text(self, at: int) -> str:
        """Return field `at`, counted from 1 behind the name, or nothing."""
        return self.fields[at - 1] if at <= len(self.fields) else ""

    def integer(self, at: int, default: int | None = None) -> int:
        """Return a field as a whole number.

        Raises
        ------
        InvalidInputError
            If it is none, or blank without a default.
        """
        text = self.text(at)
        if not text and default is not None:
            return default
        if not _INTEGER.fullmatch(text):
            raise self.wrong(at, "a whole number")
        return int(text)

    def real(self, at: int, default: float | None = None) -> float:
        """Return a field as a real number, `1.5-3` and `1D5` among them.

        Raises
        ------
        InvalidInputError
            If it is none, or blank without a default.
        """
        text = self.text(at)
        if not text and default is not None:
            return default
        match = _REAL.fullmatch(text)
        if match is None:
            raise self.wrong(at, "a real number")
        value = float(f"{match[1]}e{match[2] or match[3] or 0}")
        if not abs(value) <= 1e30:
            raise self.wrong(at, "a size that can be computed with, <= 1e30")
        return value

    def must_be(self, at: int, values: Sequence[float], feature: str) -> None:
        """Raise `InvalidInputError` unless a field is blank or has one of the values."""
        if self.text(at) and not any(abs(self.real(at) - v) <= 1e-3 * abs(v) for v in values):
            raise self.wrong(at, f"{' or '.join(f'{value:g}' for value in values)}: {feature} is not read")

    def wrong(self, at: int, requirement: str) -> InvalidInputError:
        """Return the error of a field, by card, line and place."""
        return InvalidInputError(
            f"{self.name} in line {self.line}, field {at + 1}: {self.text(at)!r}",
            field=f"{self.name} {self.fields[0] if self.fields else ''}".strip(),
            value=self.text(at),
            allowed=requirement,
            line=self.line,
        )


@dataclass(frozen=True)
class Deck:
    """Cards of a file, and the selections of its case control."""

    cards: tuple[Card, ...]
    choices: dict[str, int]  # SPC, METHOD and others, by name
    matrices: dict[str, str]  # K2GG, M2GG and others, each with the name of its matrix


def starts(head: bytes) -> bool:
    """Return whether a file that begins with these bytes may be bulk data."""
    try:
        text = head.decode("ascii")
    except UnicodeDecodeError:
        return False
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("$")), "")
    return bool(_NAME.match(first.strip())) or (bool(text.strip()) and not first)


def read_deck(payload: bytes) -> Deck:
    """Return the cards of a bulk data file.

    Raises
    ------
    InvalidInputError
        If it is no text, asks for another file, or a line continues nothing.
    """
    try:
        text = payload.decode("ascii")
    except UnicodeDecodeError as error:
        raise InvalidInputError(
            f"byte {error.start} is no character of bulk data", field="file", allowed="ASCII text"
        ) from None
    lines = [(i, line.split("$")[0].rstrip()) for i, line in enumerate(text.splitlines(), 1)]
    begin = next((k for k, (_, line) in enumerate(lines) if re.match(r"\s*BEGIN\b", line, re.I)), -1)
    choices: dict[str, int] = {}
    matrices: dict[str, str] = {}
    for _, line in lines[: max(begin, 0)]:
        if match := re.fullmatch(r"\s*([A-Z]+)\s*=\s*([0-9]{1,9})\s*", line, re.I):
            choices[match[1].upper()] = int(match[2])
        elif match := _MATRIX.fullmatch(line):
            matrices[match[1].upper()] = match[2].strip().upper()
    return Deck(tuple(_cards(lines[begin + 1 :])), choices, matrices)


def _cards(lines: Sequence[tuple[int, str]]) -> Iterator[Card]:
    name, fields, first = "", [], 0
    for number, raw in lines:
        line = raw.expandtabs(8)
        if not line.strip():
            continue
        head, own = _fields(line, number)
        if head.upper() == "ENDDATA":
            break
        if head.upper().startswith("INCLUDE"):
            raise InvalidInputError(
                f"line {number} asks for another file", field="INCLUDE", value=line, allowed="one whole file"
            )
        if head.startswith(("+", "*")) or not head:
            if not name:
                raise InvalidInputError(
                    f"line {number} continues no card", field="file", value=line, line=number
                )
            # a card's lines have eight fields each, of large ones two make eight
            fields += own
            continue
        if name:
            yield Card(name, _trimmed(fields), first)
        if not _NAME.fullmatch(head):
            raise InvalidInputError(
                f"line {number} holds no card",
                field="file",
                value=line[:80],
                line=number,
                allowed="bulk data",
            )
        name, fields, first = head.upper(), own, number
    if name:
        yield Card(name, _trimmed(fields), first)


def _fields(line: str, number: int) -> tuple[str, list[str]]:
    """Return the first field of a line, and its data fields, padded to their full number."""
    if "," in line:
        head, *data = (part.strip() for part in line.split(","))
        wide = head.endswith("*") or head.startswith("*")
        size = 4 if wide else 8
        # the one behind them may name the line that continues it
        if any(data[size + 1 :]) or (data[size:] and data[size] and data[size][0] not in "+*"):
            raise InvalidInputError(
                f"line {number} has more than {size} fields",
                field=head,
                value=line[:80],
                line=number,
                allowed="a line that continues it, which begins with + or a comma",
            )
    else:
        head = line[:8].strip()
        wide = head.endswith("*") or head.startswith("*")
        size, width = (4, 16) if wide else (8, 8)
        data = [line[8 + i * width : 8 + (i + 1) * width].strip() for i in range(size)]
    name = head if head == "*" else head.removesuffix("*")
    return name, (data + [""] * size)[:size]


def _trimmed(fields: list[str]) -> tuple[str, ...]:
    while fields and not fields[-1]:
        fields = fields[:-1]
    return tuple(fields)

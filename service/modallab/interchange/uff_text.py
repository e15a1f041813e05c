"""Elements of text datasets in universal files: marks, records, numbers in columns, header, units."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime

from modallab.interchange.settings import UNIVERSAL

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
PROGRAM = "modallab"


@dataclass(frozen=True)
class Origin:
    """Origin of the content of a file, for its header."""

    name: str = ""
    content: str = ""
    version: str = ""  # of the program that made it
    created: datetime | None = None  # when the content was made, which never changes after


NOWHERE = Origin()


def dataset(number: int, lines: Iterable[str]) -> bytes:
    """Return a text dataset between its marks."""
    return "".join(f"{line}\n" for line in ("    -1", f"{number:6d}", *lines, "    -1")).encode("ascii")


def label(text: str) -> str:
    """Return a line of free text: ASCII, 80 characters, nothing that could pass for a mark."""
    # A single blank between words: a mark has four before its -1.
    plain = " ".join(text.split()).encode("ascii", "replace").decode()
    return plain[: UNIVERSAL.text_width] or "NONE"


def front(origin: Origin) -> bytes:
    """Return the first datasets of a file: header (151) and SI units (164).

    Not by pyuff 2.5, which writes to paths only and puts the time of writing into the header, so
    that no file would be the same twice.
    """
    program = label(f"{PROGRAM} {origin.version}")
    date = "" if origin.created is None else _date(origin.created)
    header = [label(origin.name), label(origin.content), program, f"{date:<20}{0:10d}{0:10d}{0:10d}"]
    units = [f"{1:10d}{'SI: Meter (newton)':<20}{2:10d}", _factors(1.0, 1.0, 1.0), _factors(273.15)]
    return dataset(151, [*header, date, program, date]) + dataset(164, units)


def _date(timestamp: datetime) -> str:
    # Not by strftime: its month is in the language of the computer.
    day = f"{timestamp.day:02d}-{_MONTHS[timestamp.month - 1]}-{timestamp.year % 100:02d}"
    return f"{day:<10}{timestamp:%H:%M:%S}"


def _factors(*values: float) -> str:
    return "".join(f"{value:25.17E}".replace("E", "D") for value in values)


def program_of(header: str) -> str:
    """Return the program that wrote a file, from the text of its header (151) without number and marks."""
    lines = [label(line) for line in header.splitlines()]
    return next((lines[i] for i in (5, 2) if i < len(lines) and lines[i] != "NONE"), "")


def foreign(program: str) -> tuple[str, ...]:
    """Return the note of another program's file."""
    return () if not program or program.startswith(PROGRAM) else (f"written by {program}",)


def number(value: float) -> str:
    """Return a number in 13 columns with as many digits as fit: E13.5 would keep six."""
    if abs(value) < UNIVERSAL.smallest_number:
        return f"{'0.0':>{UNIVERSAL.number_width}}"
    digits = 11
    text = f"{value:#.{digits}g}"
    while len(text) >= UNIVERSAL.number_width:  # a column stays blank, for readers that split at blanks
        digits -= len(text) - UNIVERSAL.number_width + 1
        text = f"{value:#.{digits}g}"
    return f"{text:>{UNIVERSAL.number_width}}"


def rows(values: Sequence[float]) -> list[str]:
    """Return numbers in lines of six."""
    texts = [number(value) for value in values]
    return [
        "".join(texts[i : i + UNIVERSAL.numbers_per_row])
        for i in range(0, len(texts), UNIVERSAL.numbers_per_row)
    ]

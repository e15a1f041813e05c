"""Units that the names of columns state: `Real [g/N]`, `Magnitude (m/s^2/N)`, `Frequency [kHz]`."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.interchange.units import FrfUnit, frf_unit

_BEGINNINGS = re.compile(r"(?<=[\s,;:])\S|[\[(]")
_BRACKETS = re.compile(r"\[([^\[\]]*[^\W\d][^\[\]]*)\]\s*$")
_NO_UNITS = re.compile(r"(?i)db|deg|rad|°|re(al)?|im(ag)?|mag.*|abs")
_HERTZ = ((re.compile(r"(?i)\bk\s*hz\b"), 1e3), (re.compile(r"(?i)\brad\s*/\s*s"), 1 / (2 * math.pi)))


@dataclass(frozen=True)
class HeaderUnit:
    """Unit of FRFs in the names of their columns."""

    text: str = ""
    """The unit as it stands there; empty where there is none that is understood."""
    unit: FrfUnit | None = None
    """The unit; None where there is none that is understood."""
    unclear: str = ""
    """Text in square brackets that is no motion per force."""


def header_unit(names: Sequence[str]) -> HeaderUnit:
    """Return the unit that names of columns of FRFs state.

    Raises
    ------
    InvalidInputError
        If they state several.
    """
    found = {unit: text for name in names for unit, text in _units_in(name)}
    if len(found) > 1:
        raise InvalidInputError(
            "the columns of the FRFs have several units",
            field="unit",
            value=list(found.values()),
            allowed="one unit a file, or `unit` for all columns",
        )
    for unit, text in found.items():
        return HeaderUnit(text, unit)
    brackets = (match[1].strip() for match in map(_BRACKETS.search, names) if match)
    return HeaderUnit(unclear=next((text for text in brackets if not _NO_UNITS.fullmatch(text)), ""))


def hertz(name: str) -> float:
    """Return the frequency, Hz, of the number 1 in a column of frequencies with this name."""
    return next((factor for pattern, factor in _HERTZ if pattern.search(name)), 1.0)


def _units_in(name: str) -> Iterator[tuple[FrfUnit, str]]:
    """Yield the unit at the end of a name; nothing where there is none."""
    for begin in _BEGINNINGS.finditer(name):
        text = name[begin.start() :].strip()
        try:
            yield frf_unit(text), text.strip("[]")
        except InvalidInputError:
            continue
        return

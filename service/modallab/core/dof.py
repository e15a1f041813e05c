"""Degrees of freedom: a node, a direction and a sense."""

import re
from dataclasses import dataclass
from typing import Self

from modallab.core.errors import InvalidInputError

DIRECTIONS = ("X", "Y", "Z", "RX", "RY", "RZ")
TRANSLATIONS = ("X", "Y", "Z")
_PATTERN = re.compile(r"([0-9]{1,9}):([+-]?)(R?[XYZ])")


@dataclass(frozen=True, order=True)
class Dof:
    """A degree of freedom, written `5:+Y`; `sign` is -1 for a sensor that looks the other way."""

    node: int
    direction: str
    sign: int = 1

    @classmethod
    def parse(cls, text: str, *, field: str = "dof") -> Self:
        """Return the DoF written as `node:direction`.

        Raises
        ------
        InvalidInputError
            If the text is not of that form.
        """
        match = _PATTERN.fullmatch(text.strip())
        if match is None:
            raise InvalidInputError(
                f"{text!r} is not a degree of freedom",
                field=field,
                value=text,
                allowed="node:direction, such as 5:+Y, 12:-Z or 5:+RZ",
            )
        return cls(int(match[1]), match[3], -1 if match[2] == "-" else 1)

    @property
    def point(self) -> "Dof":
        """The same degree of freedom in its positive sense."""
        return self if self.sign == 1 else Dof(self.node, self.direction)

    @property
    def translational(self) -> bool:
        """True for X, Y and Z."""
        return self.direction in TRANSLATIONS

    def __str__(self) -> str:
        return f"{self.node}:{'-' if self.sign < 0 else '+'}{self.direction}"

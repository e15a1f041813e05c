"""Which correction coefficients may move: of which members, from where, how far."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import Coefficients
from modallab.fe.structure import Member, Structure

RUN_LENGTH = 4  # members in an automatic macro element, at most


class Part(StrEnum):
    """The matrix of an element that a coefficient multiplies."""

    MASS = "mass"
    STIFFNESS = "stiffness"  # axial and bending together
    AXIAL = "axial"
    BENDING = "bending"


@dataclass(frozen=True)
class MacroElement:
    """Members that share one coefficient on one of their parts; a single member is one too."""

    members: tuple[int, ...]
    part: Part

    def __str__(self) -> str:
        return f"{self.part} of {', '.join(map(str, self.members))}"


@dataclass(frozen=True)
class Parameterisation:
    """The coefficients of an update, 1 where nothing is to be corrected.

    Raises
    ------
    InvalidInputError
        If there is no macro element, a member's part is in two of them, or the bounds leave out 1.
    """

    macros: tuple[MacroElement, ...]
    lower: float = 0.05
    upper: float = 10.0

    def __post_init__(self) -> None:
        if not self.macros:
            raise InvalidInputError(
                "an update needs a macro element", field="macros", value=0, allowed=">= 1"
            )
        if not 0 < self.lower < 1 < self.upper < np.inf:
            raise InvalidInputError(
                "the bounds of a coefficient must lie on both sides of 1",
                field="lower" if not 0 < self.lower < 1 else "upper",
                value=self.lower if not 0 < self.lower < 1 else self.upper,
                allowed="0 < lower < 1 < upper",
            )
        seen: set[tuple[str, int]] = set()
        for macro in self.macros:
            for key in ((matrix, number) for matrix in _matrices(macro.part) for number in macro.members):
                if key in seen:
                    raise InvalidInputError(
                        f"member {key[1]} has two coefficients on its {key[0]} matrix",
                        field="macros",
                        value=key[1],
                        allowed="each member once for a part",
                    )
                seen.add(key)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts that have a coefficient, in the order they came."""
        return tuple(dict.fromkeys(macro.part for macro in self.macros))

    def groups(self, structure: Structure) -> FloatArray:
        """Return (n_macros, n_members): 1 where a member belongs to a macro element.

        Raises
        ------
        InvalidInputError
            If the structure has no such member.
        """
        place = {member.number: i for i, member in enumerate(structure.members)}
        table = np.zeros((len(self.macros), len(place)))
        for row, macro in enumerate(self.macros):
            for number in macro.members:
                table[row, place[structure.member(number).number]] = 1.0
        return table


def _matrices(part: Part) -> tuple[str, ...]:
    return ("axial", "bending") if part is Part.STIFFNESS else (part.value,)


def parameterise(
    groups: Iterable[Sequence[int]],
    parts: Sequence[str] = (Part.MASS, Part.STIFFNESS),
    *,
    lower: float = 0.05,
    upper: float = 10.0,
) -> Parameterisation:
    """Return one macro element for every group of members and every part.

    Raises
    ------
    InvalidInputError
        If a part is unknown, or a group holds nothing or the same member twice.
    """
    for part in parts:
        if part not in tuple(Part):
            raise InvalidInputError(
                f"elements have no part {part!r}", field="parts", value=part, allowed=", ".join(Part)
            )
    members = [tuple(int(number) for number in group) for group in groups]
    if not all(members):
        raise InvalidInputError("a macro element has no member", field="macros", value="[]", allowed=">= 1")
    macros = tuple(MacroElement(group, Part(part)) for part in parts for group in members)
    return Parameterisation(macros, lower, upper)


def automatic_groups(structure: Structure) -> tuple[tuple[int, ...], ...]:
    """Return macro elements for a structure that nobody has divided.

    Members that follow one another in a straight line, of one section and material and with nothing
    else at the nodes between them, are one run; a run is cut into the fewest pieces of at most
    four members, as equal as they can be. Seven make 4 + 3, as the thesis divides its bars.
    """
    at_node: dict[int, int] = {}
    for member in structure.members:
        for node in member.nodes:
            at_node[node] = at_node.get(node, 0) + 1

    def continues(one: Member, other: Member) -> bool:
        shared = set(one.nodes) & set(other.nodes)
        alike = (one.section, one.material, one.element) == (other.section, other.material, other.element)
        return len(shared) == 1 and at_node[shared.pop()] == 2 and alike and _aligned(structure, one, other)

    runs = [[structure.members[0]]]
    for one, other in pairwise(structure.members):
        if continues(one, other):
            runs[-1].append(other)
        else:
            runs.append([other])
    pieces = (np.array_split([m.number for m in run], -(-len(run) // RUN_LENGTH)) for run in runs)
    return tuple(tuple(int(number) for number in piece) for run in pieces for piece in run)


def _aligned(structure: Structure, one: Member, other: Member) -> bool:
    def direction(member: Member) -> FloatArray:
        start, end = (np.array(structure.nodes[n]) for n in member.nodes)
        return np.asarray((end - start) / structure.length(member))

    return bool(abs(abs(direction(one) @ direction(other)) - 1.0) < 1e-9)


def spread_over_members(
    parameterisation: Parameterisation, groups: FloatArray, values: FloatArray, base: Coefficients
) -> Coefficients:
    """Return what multiplies each member's parts: the structure's own factors times the coefficients.

    Parameters
    ----------
    groups
        (n_macros, n_members), from `Parameterisation.groups`.
    values
        (n_macros,) coefficients.
    base
        What the structure's members carry.
    """
    factors = {name: np.ones(groups.shape[1]) for name in ("mass", "axial", "bending")}
    for macro, row, value in zip(parameterisation.macros, groups, values, strict=True):
        for name in _matrices(macro.part):
            factors[name][row > 0] *= value
    return Coefficients(
        mass=base.mass * factors["mass"],
        axial=base.axial * factors["axial"],
        bending=base.bending * factors["bending"],
        loss_factor=base.loss_factor,
    )


def by_member(
    parameterisation: Parameterisation,
    values: FloatArray,
    *,
    parts: Iterable[Part],
    members: Iterable[int] = (),
) -> dict[str, dict[int, float]]:
    """Return values (n_macros,) by part and member number; 1 for the other `members` named."""
    numbers = tuple(members)
    table = {part.value: dict.fromkeys(numbers, 1.0) for part in parts}
    for macro, value in zip(parameterisation.macros, values, strict=True):
        table[macro.part.value].update(dict.fromkeys(macro.members, float(value)))
    return table

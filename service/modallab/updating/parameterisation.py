"""Correction coefficients of an update: their macro elements, nominal values and bounds."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.assembly import Coefficients
from modallab.fe.section_size import size
from modallab.fe.structure import Structure
from modallab.updating.nodal_elements import check_nodal_values, nodal_values
from modallab.updating.part import Part as Part
from modallab.updating.part import check_part_overlap
from modallab.updating.settings import COEFFICIENTS


@dataclass(frozen=True)
class MacroElement:
    """Members that share one coefficient of one part; a single member is one too.

    Nodes in place of members for parts of nodes.
    """

    members: tuple[int, ...]
    """Numbers of the members, or nodes, that share the coefficient."""
    part: Part
    """Corrected part of their matrices."""

    def __str__(self) -> str:
        return f"{self.part} of {'node ' * self.part.is_nodal}{', '.join(map(str, self.members))}"


@dataclass(frozen=True)
class Parameterisation:
    """Coefficients of an update: nominal 1, for damping 0.

    The bounds are those of coefficients that multiply a matrix; loss factors have
    `COEFFICIENTS.loss_factor_bounds`.

    Raises
    ------
    InvalidInputError
        If there is no macro element, a part of a member is in two of them, a matrix depends on its own
        coefficient and on that of a property, or the bounds exclude 1.
    """

    macros: tuple[MacroElement, ...]
    """(n_params,) macro element of each coefficient."""
    lower: float = COEFFICIENTS.lower
    """Lower bound of the coefficients that multiply a matrix."""
    upper: float = COEFFICIENTS.upper
    """Upper bound of the coefficients that multiply a matrix."""

    def __post_init__(self) -> None:
        if not self.macros:
            raise InvalidInputError(
                "an update needs a macro element", field="macros", value=0, allowed=bounds(1)
            )
        if not 0 < self.lower < 1 < self.upper < np.inf:
            raise InvalidInputError(
                "the bounds of a coefficient must lie on both sides of 1",
                field="lower" if not 0 < self.lower < 1 else "upper",
                value=self.lower if not 0 < self.lower < 1 else self.upper,
                allowed="0 < lower < 1 < upper",
            )
        parts_of_member: dict[int, list[Part]] = {}
        for macro in self.macros:
            for number in macro.members:
                parts = parts_of_member.setdefault(number, [])
                for part in parts:
                    check_part_overlap(number, macro.part, part)
                parts.append(macro.part)

    @property
    def parts(self) -> tuple[Part, ...]:
        """Parts with a coefficient, in order of first use."""
        return tuple(dict.fromkeys(macro.part for macro in self.macros))

    @property
    def damping(self) -> BoolArray:
        """(n_macros,) True for coefficients that are loss factors."""
        return np.array([macro.part is Part.DAMPING for macro in self.macros])

    @property
    def nominal(self) -> FloatArray:
        """(n_macros,) coefficients that leave the model unchanged."""
        return np.array([macro.part.nominal for macro in self.macros])

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bound of every coefficient, (n_macros,) each."""
        least, most = COEFFICIENTS.loss_factor_bounds
        return np.where(self.damping, least, self.lower), np.where(self.damping, most, self.upper)

    def groups(self, structure: Structure) -> FloatArray:
        """Return the membership matrix (n_macros, n_members): 1 for members of a macro element.

        Raises
        ------
        InvalidInputError
            If the structure lacks a member, the member a property, or the node the mass, spring or joint.
        """
        place = {member.number: i for i, member in enumerate(structure.all_members)}
        table = np.zeros((len(self.macros), len(place)))
        for row, macro in enumerate(self.macros):
            if macro.part.is_nodal:
                check_nodal_values(structure, macro.part, macro.members)
                continue
            for number in macro.members:
                member = structure.member(number)
                if macro.part.section_size:
                    size(member, macro.part.section_size, field="parts")
                table[row, place[member.number]] = 1.0
        return table


def parameterise(
    groups: Iterable[Sequence[int]],
    parts: Sequence[str] = (Part.MASS, Part.STIFFNESS),
    *,
    lower: float = COEFFICIENTS.lower,
    upper: float = COEFFICIENTS.upper,
    nodal: tuple[MacroElement, ...] = (),
) -> Parameterisation:
    """Return one macro element for every group of members and every part, followed by those of nodes.

    Raises
    ------
    InvalidInputError
        If a part is unknown, or a group is empty or has the same member twice.
    """
    element_parts = [part for part in Part if not part.is_nodal]
    for part in parts:
        if part not in element_parts:
            raise InvalidInputError(
                f"elements have no part {part!r}", field="parts", value=part, allowed=list(element_parts)
            )
    members = [tuple(int(number) for number in group) for group in groups]
    if not all(members):
        raise InvalidInputError("a macro element has no member", field="macros", value=[], allowed=bounds(1))
    macros = tuple(MacroElement(group, Part(part)) for part in parts for group in members)
    return Parameterisation((*macros, *nodal), lower, upper)


def at_nodes(
    structure: Structure, groups_by_part: Mapping[str, Iterable[Sequence[int]] | None]
) -> tuple[MacroElement, ...]:
    """Return macro elements of nodes by part: groups of nodes, or None for each node by itself.

    Raises
    ------
    InvalidInputError
        If no node has the part.
    """
    nodal_parts = {part.value: part for part in Part if part.is_nodal}
    macros = []
    for name, groups in groups_by_part.items():
        if name not in nodal_parts:
            raise InvalidInputError(
                f"nodes carry no {name!r}", field="attached", value=name, allowed=list(nodal_parts)
            )
        part = nodal_parts[name]
        node_groups = [(node,) for node in nodal_values(structure, part)] if groups is None else list(groups)
        if not node_groups or not all(node_groups):
            raise InvalidInputError(
                f"no node carries a {part.label}" if groups is None else f"{name} is of no node",
                field="attached",
                value=name,
                allowed=list(nodal_values(structure, part)) or "no node",
            )
        macros += [MacroElement(tuple(int(node) for node in group), part) for group in node_groups]
    return tuple(macros)


def check_no_loss_factors(parameterisation: Parameterisation) -> None:
    """Raise `InvalidInputError` if loss factors are to be found from real modes."""
    if parameterisation.damping.any():
        raise InvalidInputError(
            "a method of real modes finds no damping",
            field="parts",
            value=Part.DAMPING.value,
            allowed=[part for part in Part if part is not Part.DAMPING],
        )


def member_coefficients(
    parameterisation: Parameterisation, groups: FloatArray, values: FloatArray, base: Coefficients
) -> Coefficients:
    """Return the factors of each member's matrices: the structure's own times the coefficients.

    Loss factors are added to the structure's own. Sizes, such as area or thickness, are no factors: the
    matrices themselves depend on them.

    Parameters
    ----------
    groups
        (n_macros, n_members), from `Parameterisation.groups`.
    values
        (n_macros,) coefficients.
    base
        Factors of the structure's members.
    """
    factors = {name: np.ones(groups.shape[1]) for name in ("mass", "axial", "bending")}
    added = np.zeros(groups.shape[1])
    for macro, row, value in zip(parameterisation.macros, groups, values, strict=True):
        if macro.part is Part.DAMPING:
            added[row > 0] += value
        elif macro.part.section_size is None and not macro.part.is_nodal:
            for name in macro.part.matrices:
                factors[name][row > 0] *= value
    return Coefficients(
        mass=base.mass * factors["mass"],
        axial=base.axial * factors["axial"],
        bending=base.bending * factors["bending"],
        loss_factor=base.loss_factor + added,
    )


def by_member(
    parameterisation: Parameterisation,
    values: FloatArray,
    *,
    parts: Iterable[Part],
    members: Iterable[int] = (),
) -> dict[str, dict[int, float]]:
    """Return values (n_macros,) by part and member number, nominal for the other `members`.

    Parts of nodes are by node number.
    """
    numbers = tuple(members)
    table = {part.value: dict.fromkeys(() if part.is_nodal else numbers, part.nominal) for part in parts}
    for macro, value in zip(parameterisation.macros, values, strict=True):
        table[macro.part.value].update(dict.fromkeys(macro.members, float(value)))
    return table

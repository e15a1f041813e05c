"""A structure from bulk data: cards that carry mass and stiffness, and those that are left out."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.imported_elements import Element, elements_of_groups, of_elements
from modallab.fe.structure import Structure, Support
from modallab.interchange.nastran import elements as made
from modallab.interchange.nastran.deck import Deck, read_deck
from modallab.interchange.nastran.direct import DirectMatrices, direct_matrices
from modallab.interchange.nastran.grid import Place, grid_points, supports
from modallab.interchange.nastran.properties import BARS

READ_CARDS = frozenset(
    [
        "GRID",
        "GRDSET",
        "MAT1",
        *BARS,
        "PSHELL",
        "PELAS",
        "SPC",
        "SPC1",
        "SPCADD",
        "PARAM",
        "DMIG",
        *made.CARDS,
    ]
)
# Loads, requests and tables, without influence on mass, stiffness or supports.
IGNORED_CARDS = frozenset(
    """
    ASET ASET1 CORD1R CORD2R CORD1C CORD2C CORD1S CORD2S DAREA DLOAD EIGB EIGC EIGR EIGRL FORCE FORCE1
    FORCE2 FREQ FREQ1 FREQ2 FREQ3 FREQ4 FREQ5 GRAV LOAD MOMENT MOMENT1 MOMENT2 PLOAD PLOAD1 PLOAD2 PLOAD4
    PLOTEL RFORCE RLOAD1 RLOAD2 SET1 SET3 SUPORT SUPORT1 TABDMP1 TABLED1 TABLED2 TABLED3 TABLED4 TEMP TEMPD
    TLOAD1 TLOAD2 TSTEP USET USET1
    """.split()  # noqa: SIM905
)


def read(payload: bytes, *, damping: Damping | None = None, name: str = "") -> Structure:
    """Return the structure of a bulk data file in SI units.

    Members are its elements by number, in groups by property, and its DMIG matrices as one more group.
    Masses are consistent. Directions without stiffness are left out, as by AUTOSPC.

    Raises
    ------
    InvalidInputError
        If a card carries mass, stiffness or constraints and is not read, a field is at fault, or the
        structure cannot be analysed.
    """
    deck = read_deck(payload)
    _refuse_unknown(deck)
    direct = direct_matrices(deck)
    places, held_points = _grid_points(deck, direct)
    held_points = [*held_points, *supports(deck, places)]
    for support in held_points:
        if support.node not in places:
            raise InvalidInputError(
                f"there is no grid point {support.node} to hold",
                field="SPC",
                value=support.node,
                allowed="grid points of this file",
            )
    cards = [card for card in deck.cards if card.name in made.CARDS]
    ends = {made.grid_point_of(card, at, places) for card in cards for at in made.point_fields(card)}
    used = sorted(ends.union(direct.points if direct else ()))
    table = [Dof(node, direction) for node in used for direction in DIRECTIONS]
    row = {(dof.node, dof.direction): i for i, dof in enumerate(table)}
    members = made.build(cards, made.element_references(deck, places, row))
    scale, loss = _parameters(deck)
    members = [replace(element, mass=scale * element.mass) for element in members]
    if direct:
        # DMIG matrices are in units of mass already.
        first = max((element.number for element in members), default=0) + 1
        members += elements_of_groups([direct.group(row)], table, first=first)
    elements, dofs = _with_stiffness(members, table)
    return of_elements(
        elements,
        dofs,
        {dof.node: places[dof.node] for dof in dofs},
        supports=_merged(held_points, dofs),
        damping=damping or StructuralDamping(stiffness_coefficient=loss),
        name=name,
    )


def _grid_points(deck: Deck, direct: DirectMatrices | None) -> tuple[Mapping[int, Place], Sequence[Support]]:
    """Return positions of grid points, m, and their supports; a file of matrices alone may omit both."""
    places, supports = grid_points(deck.cards)
    points = direct.points if direct else {}
    if not places:
        places = dict.fromkeys(points, (0.0, 0.0, 0.0))
    missing = next((point for point in points if point not in places), None)
    if missing is not None or not places:
        raise InvalidInputError(
            "the file has no grid points" if missing is None else f"there is no grid point {missing}",
            field="GRID" if missing is None else "DMIG",
            value=missing or 0,
            allowed="grid points of this file, one or more",
        )
    return places, supports


def _refuse_unknown(deck: Deck) -> None:
    unknown = Counter(card.name for card in deck.cards if card.name not in READ_CARDS | IGNORED_CARDS)
    if unknown:
        listed = ", ".join(f"{name} ({n})" for name, n in sorted(unknown.items())[:20])
        raise InvalidInputError(
            f"cards that are not read: {listed}",
            field="file",
            value=listed,
            allowed=sorted(READ_CARDS),
            line=next(card.line for card in deck.cards if card.name in unknown),
        )


def _parameters(deck: Deck) -> tuple[float, float]:
    """Return the factor of all masses (WTMASS), and the loss factor of all elements (G)."""
    scale, loss = 1.0, 0.0
    for card in deck.cards:
        if card.name == "PARAM" and card.text(1).upper() == "WTMASS":
            scale = card.real(2)
            if scale <= 0:
                raise card.wrong(2, "> 0")
        if card.name == "PARAM" and card.text(1).upper() == "G":
            loss = card.real(2)
            if loss < 0:
                raise card.wrong(2, ">= 0")
    return scale, loss


def _with_stiffness(
    elements: Sequence[Element], table: Sequence[Dof]
) -> tuple[list[Element], tuple[Dof, ...]]:
    """Return elements and degrees of freedom without those that have no stiffness."""
    diagonal = np.zeros(len(table))
    for element in elements:
        stiffness = element.axial if element.bending is None else element.axial + element.bending
        np.add.at(diagonal, element.rows, np.diag(stiffness))
    is_stiff = np.zeros(len(table), bool)
    translational = np.array([dof.translational for dof in table], bool)
    for kind in (translational, ~translational):
        is_stiff |= kind & (diagonal > PRODUCT_ROUNDING * diagonal[kind].max(initial=0.0))
    place = np.cumsum(is_stiff) - 1
    reduced = []
    for element in elements:
        entries = np.flatnonzero(is_stiff[list(element.rows)])
        if not len(entries):
            continue
        at = np.ix_(entries, entries)
        reduced.append(
            replace(
                element,
                rows=place[np.array(element.rows)[entries]].tolist(),
                mass=element.mass[at],
                axial=element.axial[at],
                bending=None if element.bending is None else element.bending[at],
            )
        )
    return reduced, tuple(dof for dof, stiff in zip(table, is_stiff, strict=True) if stiff)


def _merged(supports: Sequence[Support], dofs: Sequence[Dof]) -> tuple[Support, ...]:
    """Return the supports of existing degrees of freedom, one for each node."""
    existing = set(dofs)
    by_node: dict[int, dict[str, None]] = {}
    for support in supports:
        for direction in support.directions:
            if Dof(support.node, direction) in existing:
                by_node.setdefault(support.node, {})[direction] = None
    return tuple(Support(node, tuple(directions)) for node, directions in by_node.items())

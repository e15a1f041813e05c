"""Matrices that bulk data give entry by entry: DMIG."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from scipy.sparse import csc_array

from modallab.core.dof import DIRECTIONS
from modallab.core.errors import InvalidInputError
from modallab.fe.imported_elements import GroupMatrices
from modallab.interchange.nastran.deck import Card, Deck

SQUARE, SYMMETRIC = 1, 6
REAL = (1, 2)  # single, double
KINDS = {"K2GG": "stiffness", "M2GG": "mass"}  # purpose of a matrix that case control selects
LETTERS = {"K": "stiffness", "M": "mass"}  # first letter of a name without selection
GROUP = "DMIG"

Motion = tuple[int, str]  # of a grid point in a direction
Entries = dict[tuple[Motion, Motion], float]


@dataclass(frozen=True, eq=False)
class DirectMatrices:
    """Mass and stiffness by the motions that they join, both ways."""

    mass: Entries  # kg, kg m, kg m^2
    stiffness: Entries  # N/m, N, N m

    @property
    def points(self) -> dict[int, None]:
        """Grid points that have a row."""
        return {point: None for part in (self.mass, self.stiffness) for (point, _), _ in part}

    def group(self, row: Mapping[Motion, int]) -> GroupMatrices:
        """Return both as matrices (n, n) at rows of a table of degrees of freedom."""
        return GroupMatrices(GROUP, *(_matrix(part, row) for part in (self.mass, self.stiffness)))


def direct_matrices(deck: Deck) -> DirectMatrices | None:
    """Return mass and stiffness matrices of a deck's DMIG cards; None if it has none.

    Raises
    ------
    InvalidInputError
        If it is open which matrices are meant, one is complex or not square, an entry is there twice, or at
        a scalar point.
    """
    cards: dict[str, list[Card]] = {}
    for card in deck.cards:
        if card.name == "DMIG":
            cards.setdefault(card.text(1).upper(), []).append(card)
    chosen = _chosen(deck, tuple(cards))
    if not chosen:
        return None
    matrices = {kind: _entries(cards[name]) for kind, name in chosen.items()}
    return DirectMatrices(matrices.get("mass", {}), matrices.get("stiffness", {}))


def _chosen(deck: Deck, names: Sequence[str]) -> dict[str, str]:
    """Return the name of the stiffness and of the mass."""
    for use, name in deck.matrices.items():
        if use not in KINDS or name not in names:
            raise InvalidInputError(
                f"{use} = {name} is not read" if use not in KINDS else f"there is no matrix {name}",
                field=use,
                value=name,
                allowed=f"{' and '.join(KINDS)}, each of one matrix among {', '.join(names) or 'none'}",
            )
    if deck.matrices:
        return {KINDS[use]: name for use, name in deck.matrices.items()}
    chosen: dict[str, str] = {}
    for name in names:
        kind = LETTERS.get(name[:1])
        if kind is None or kind in chosen:
            raise InvalidInputError(
                f"nothing chooses among the matrices {', '.join(names)}",
                field="DMIG",
                value=name,
                allowed="K2GG = NAME and M2GG = NAME in case control; or one that begins with K, one with M",
            )
        chosen[kind] = name
    return chosen


def _entries(cards: Sequence[Card]) -> Entries:
    """Return the entries of one matrix."""
    head = next((card for card in cards if card.text(2) == "0"), None)
    if head is None:
        raise cards[0].wrong(2, "0 of a first card, which says what matrix it is")
    form = head.integer(3)
    if form not in (SQUARE, SYMMETRIC):
        raise head.wrong(3, "1: square, 6: symmetric")
    if head.integer(4) not in REAL:
        raise head.wrong(4, "1 or 2: real")
    entries: Entries = {}
    for card in cards:
        if card is head:
            continue
        column = _motion(card, 2)
        for at, row, value in _column(card):
            if (row, column) in entries:
                raise card.wrong(at, "each entry once, of a symmetric matrix on one side")
            entries[row, column] = value
            if form == SYMMETRIC:
                entries[column, row] = value
    return entries


def _column(card: Card) -> Iterator[tuple[int, Motion, float]]:
    """Yield the entries of a card, (G, C, A, B), with their first fields; B is the imaginary part."""
    for at in range(5, len(card.fields) + 1, 4):
        if any(card.text(at + i) for i in range(4)):
            yield at, _motion(card, at), card.real(at + 2, 0.0)


def _motion(card: Card, at: int) -> Motion:
    direction = card.integer(at + 1, 0)
    if not 1 <= direction <= len(DIRECTIONS):
        raise card.wrong(at + 1, "1 to 6: scalar points are not read")
    return card.integer(at), DIRECTIONS[direction - 1]


def _matrix(entries: Entries, row: Mapping[Motion, int]) -> csc_array:
    rows, columns = ([row[motions[i]] for motions in entries] for i in (0, 1))
    return csc_array((list(entries.values()), (rows, columns)), shape=(len(row), len(row)))

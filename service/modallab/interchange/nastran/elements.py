"""Elements of bulk data as matrices at the degrees of freedom of their grid points."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.imported_elements import Element
from modallab.fe.settings import INPUT
from modallab.fe.spatial import (
    SpatialBars,
    SpatialPlates,
    bar_axes,
    bars_in_space,
    convex,
    plates_in_space,
    warp,
)
from modallab.interchange.nastran.deck import Card, Deck
from modallab.interchange.nastran.grid import Place, components
from modallab.interchange.nastran.properties import (
    BARS,
    BarProperty,
    Mat,
    PlateProperty,
    by_number,
    material,
    prod,
    pshell,
)

CORNERS = {"CQUAD4": 4, "CTRIA3": 3}
STRAIGHT = ("CBAR", "CBEAM", "CROD", "CONROD")
CARDS = (*STRAIGHT, *CORNERS, "CONM2", "CELAS1", "CELAS2")
SHORTEST = 1e-9  # m


@dataclass(frozen=True, eq=False)
class Given:
    """What elements refer to."""

    places: Mapping[int, Place]  # m
    materials: Mapping[int, Mat]
    properties: Mapping[int, BarProperty | PlateProperty]
    springs: Mapping[int, Card]  # PELAS
    row: Mapping[tuple[int, str], int]  # of a grid point's direction

    def point(self, card: Card, at: int) -> int:
        """Return the grid point that a field names."""
        return known_point(card, at, self.places)

    def rows(self, points: Sequence[int]) -> list[int]:
        """Return the rows of all directions of some grid points."""
        first = [self.row[point, "X"] for point in points]
        return [start + i for start in first for i in range(6)]


def known_point(card: Card, at: int, places: Mapping[int, Place]) -> int:
    """Return the grid point that a field names; `InvalidInputError` if there is none."""
    number = card.integer(at)
    if number not in places:
        raise card.wrong(at, "a grid point of this file")
    return number


def ends_of(card: Card) -> tuple[int, ...]:
    """Return the fields of an element that name grid points, orientation left out."""
    if card.name == "CONROD":
        return (2, 3)
    if card.name == "CONM2":
        return (2,)
    if card.name.startswith("CELAS"):
        return tuple(at for at in (3, 5) if card.text(at) and card.text(at) != "0")
    return tuple(range(3, 3 + CORNERS.get(card.name, 2)))


def given(deck: Deck, places: Mapping[int, Place], row: Mapping[tuple[int, str], int]) -> Given:
    """Return the materials and properties of a deck."""
    of = {
        name: [card for card in deck.cards if card.name == name]
        for name in (*BARS, "MAT1", "PSHELL", "PELAS")
    }
    materials = {number: material(card) for number, card in by_number(of["MAT1"], "materials").items()}
    cards = by_number([card for name in (*BARS, "PSHELL") for card in of[name]], "properties")
    properties: dict[int, BarProperty | PlateProperty] = {}
    for number, card in cards.items():
        read = BARS.get(card.name)
        properties[number] = pshell(card, materials) if read is None else read(card, materials)
    return Given(places, materials, properties, by_number(of["PELAS"], "springs"), row)


def build(cards: Sequence[Card], known: Given) -> list[Element]:
    """Return the elements of a deck in the order of their numbers."""
    by = by_number(cards, "elements")
    out: list[Element] = []
    straight = [card for card in by.values() if card.name in STRAIGHT]
    if straight:
        out += _bars(straight, known)
    for name in CORNERS:
        plates = [card for card in by.values() if card.name == name]
        if plates:
            out += _plates(plates, known)
    points: Mapping[str, Callable[[Card, Given], Element]] = {
        "CONM2": _mass,
        "CELAS1": _spring,
        "CELAS2": _spring,
    }
    out += [points[card.name](card, known) for card in by.values() if card.name in points]
    return sorted(out, key=lambda element: element.number)


def _bar_property(card: Card, known: Given) -> BarProperty:
    if card.name == "CONROD":
        # EID, G1, G2, MID, A, J, C, NSM as PID, MID, A, J, C, NSM of a PROD
        fields = (card.fields[0], *card.fields[3:])
        return prod(Card("CONROD", fields, card.line), known.materials)
    found = known.properties.get(card.integer(2, card.integer(1)))
    kinds = {"CBAR": ("PBAR", "PBARL"), "CBEAM": ("PBEAM",), "CROD": ("PROD",)}[card.name]
    if not isinstance(found, BarProperty) or found.name.split()[0] not in kinds:
        raise card.wrong(2, f"the number of a {' or '.join(kinds)} of this file")
    return found


def _upright(card: Card, ends: tuple[int, int], known: Given) -> FloatArray:
    """Return the vector that turns a bar about its axis: of X1, X2, X3, or towards a grid point."""
    start, end = (np.array(known.places[point]) for point in ends)
    if card.name in ("CROD", "CONROD"):
        across = np.zeros(3)
        across[np.abs(end - start).argmin()] = 1.0  # no matter which: a rod has no bending
        return across
    for at in (*range(9, 11), *range(11, 17)):
        card.must_be(at, (0.0,), "a pin or an offset")
    if card.text(8) and card.text(8).upper() not in ("GGG", "BGG", "GGO", "GOG", "GOO"):
        card.must_be(8, (0.0, 1.0, 2.0), "an offset vector in other axes")
    if card.text(5) and not card.text(6) and not card.text(7) and card.text(5).isdigit():
        return np.asarray(np.array(known.places[known.point(card, 5)]) - start)
    return np.array([card.real(at, 0.0) for at in (5, 6, 7)])


def _bars(cards: Sequence[Card], known: Given) -> list[Element]:
    ends = [tuple(known.point(card, at) for at in ends_of(card)) for card in cards]
    own = [_bar_property(card, known) for card in cards]
    along = np.array([np.subtract(known.places[b], known.places[a]) for a, b in ends])
    for card, vector in zip(cards, along, strict=True):
        if np.linalg.norm(vector) < SHORTEST:
            raise card.wrong(3, "two grid points apart")
    density = np.array([one.material.density for one in own])
    area, torsion = np.array([one.area for one in own]), np.array([one.torsion for one in own])
    second = np.array([one.second_moments for one in own])
    # a section's own polar moment; that of a rod, which has none, is its torsion constant
    polar = np.where(second.sum(axis=1) > 0, second.sum(axis=1), torsion)
    bars = SpatialBars(
        along=along,
        upright=np.array([_upright(card, (a, b), known) for card, (a, b) in zip(cards, ends, strict=True)]),
        modulus=np.array([one.material.modulus for one in own]),
        shear_modulus=np.array([one.material.shear_modulus for one in own]),
        area=area,
        second_moments=second,
        torsion=torsion,
        line_mass=density * area + [one.more_mass for one in own],
        polar_mass=density * polar,
        shear_coefficients=np.array([one.shear_coefficients for one in own]),
    )
    for card, axes in zip(cards, bar_axes(bars), strict=True):
        if not np.isfinite(axes).all():
            raise card.wrong(5, "a vector that does not lie along the bar")
    matrices = zip(*bars_in_space(bars), strict=True)
    return [
        Element(card.integer(1), one.name, known.rows(pair), *matrices_of, one.material.loss_factor)
        for card, pair, one, matrices_of in zip(cards, ends, own, matrices, strict=True)
    ]


def _plates(cards: Sequence[Card], known: Given) -> list[Element]:
    points = [tuple(known.point(card, at) for at in ends_of(card)) for card in cards]
    own: list[PlateProperty] = []
    for card in cards:
        found = known.properties.get(card.integer(2, card.integer(1)))
        if not isinstance(found, PlateProperty):
            raise card.wrong(2, "the number of a PSHELL of this file")
        k = CORNERS[card.name]
        card.must_be(4 + k, (0.0,), "an offset ZOFFS")
        for at in range(9, 15):
            if card.text(at):
                raise card.wrong(at, "blank: thickness by corner is not read")
        own.append(found)
    corners = np.array([[known.places[point] for point in rim] for rim in points])
    _check_flat(cards, corners)
    thickness = np.array([one.thickness for one in own])
    more = np.array([one.more_mass for one in own])
    plates = SpatialPlates(
        corners=corners,
        thickness=thickness,
        modulus=np.array([one.material.modulus for one in own]),
        density=np.array([one.material.density for one in own]) + more / thickness,
        poisson_ratio=np.array([one.material.poisson_ratio for one in own]),
    )
    out = []
    for card, rim, one, mass, axial, bending in zip(
        cards, points, own, *plates_in_space(plates), strict=True
    ):
        parts = axial * one.membrane, bending * one.bending
        out.append(
            Element(card.integer(1), one.name, known.rows(rim), mass, *parts, one.material.loss_factor)
        )
    return out


def _check_flat(cards: Sequence[Card], corners: FloatArray) -> None:
    for card, fits in zip(cards, convex(corners), strict=True):
        if not fits:
            raise card.wrong(3, "corners round a convex shape, one way or the other")
    for card, off in zip(cards, warp(corners), strict=True):
        if off > INPUT.max_warp:
            raise card.wrong(3, f"corners in one plane, to {INPUT.max_warp:g} of its size")


def _mass(card: Card, known: Given) -> Element:
    if card.text(3) and card.integer(3) != 0:
        raise card.wrong(3, "0 or blank: other systems of coordinates are not read")
    mass = card.real(4)
    if mass < 0:
        raise card.wrong(4, ">= 0")
    x, y, z = (card.real(at, 0.0) for at in (5, 6, 7))
    i11, i21, i22, i31, i32, i33 = (card.real(at, 0.0) for at in range(9, 15))
    inertia = np.array([[i11, -i21, -i31], [-i21, i22, -i32], [-i31, -i32, i33]])
    # a motion u and a turn t of the point move the centre of mass by u + t x r
    arm = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass * np.eye(3)
    matrix[:3, 3:] = mass * arm
    matrix[3:, :3] = mass * arm.T
    matrix[3:, 3:] = mass * arm.T @ arm + inertia
    point = known.point(card, 2)
    return Element(card.integer(1), "CONM2", known.rows([point]), matrix, np.zeros((6, 6)))


def _spring(card: Card, known: Given) -> Element:
    if card.name == "CELAS1":
        number = card.integer(2, card.integer(1))
        if number not in known.springs:
            raise card.wrong(2, "the number of a PELAS of this file")
        own = known.springs[number]
        name, stiffness, loss = f"PELAS {number}", own.real(2), own.real(3, 0.0)
    else:
        name, stiffness, loss = "CELAS2", card.real(2), card.real(7, 0.0)
    if stiffness < 0 or loss < 0:
        raise card.wrong(2, "a stiffness and a loss factor >= 0")
    rows = []
    for at in ends_of(card):
        directions = components(card, at + 1)
        if len(directions) != 1:
            raise card.wrong(at + 1, "one of the digits 1 to 6")
        rows.append(known.row[known.point(card, at), directions[0]])
    if len(set(rows)) != len(rows) or not rows:
        raise InvalidInputError(
            f"spring {card.integer(1)} in line {card.line} joins nothing",
            field=f"{card.name} {card.integer(1)}",
            value=len(rows),
            allowed="one degree of freedom and the ground, or two",
        )
    signs = np.array([1.0, -1.0])[: len(rows)]
    matrix = stiffness * np.outer(signs, signs)
    return Element(card.integer(1), name, rows, np.zeros_like(matrix), matrix, loss_factor=loss or None)

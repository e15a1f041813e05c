"""Elements of bulk data as matrices at the degrees of freedom of their grid points."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.imported_elements import Element
from modallab.fe.spatial import (
    SpatialBars,
    SpatialPlates,
    bar_axes,
    bars_in_space,
    convex,
    plates_in_space,
    warp,
)
from modallab.fe.structure_settings import INPUT
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
from modallab.interchange.settings import MODEL_FILE

CORNERS = {"CQUAD4": 4, "CTRIA3": 3}
STRAIGHT = ("CBAR", "CBEAM", "CROD", "CONROD")
CARDS = (*STRAIGHT, *CORNERS, "CONM2", "CELAS1", "CELAS2")


@dataclass(frozen=True, eq=False)
class ElementReferences:
    """Grid points, materials, properties and rows that elements refer to."""

    places: Mapping[int, Place]  # m
    materials: Mapping[int, Mat]
    properties: Mapping[int, BarProperty | PlateProperty]
    springs: Mapping[int, Card]  # PELAS
    row: Mapping[tuple[int, str], int]  # of a grid point's direction

    def point(self, card: Card, at: int) -> int:
        """Return the grid point that a field names."""
        return grid_point_of(card, at, self.places)

    def rows(self, points: Sequence[int]) -> list[int]:
        """Return the rows of all directions of some grid points."""
        first = [self.row[point, "X"] for point in points]
        return [start + i for start in first for i in range(6)]


def grid_point_of(card: Card, at: int, places: Mapping[int, Place]) -> int:
    """Return the grid point of a field; raise `InvalidInputError` if it does not exist."""
    number = card.integer(at)
    if number not in places:
        raise card.wrong(at, "a grid point of this file")
    return number


def point_fields(card: Card) -> tuple[int, ...]:
    """Return the fields of an element that name grid points, orientation left out."""
    if card.name == "CONROD":
        return (2, 3)
    if card.name == "CONM2":
        return (2,)
    if card.name.startswith("CELAS"):
        return tuple(at for at in (3, 5) if card.text(at) and card.text(at) != "0")
    return tuple(range(3, 3 + CORNERS.get(card.name, 2)))


def element_references(
    deck: Deck, places: Mapping[int, Place], row: Mapping[tuple[int, str], int]
) -> ElementReferences:
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
    return ElementReferences(places, materials, properties, by_number(of["PELAS"], "springs"), row)


def build(cards: Sequence[Card], references: ElementReferences) -> list[Element]:
    """Return the elements of a deck in the order of their numbers."""
    by = by_number(cards, "elements")
    out: list[Element] = []
    straight = [card for card in by.values() if card.name in STRAIGHT]
    if straight:
        out += _bars(straight, references)
    for name in CORNERS:
        plates = [card for card in by.values() if card.name == name]
        if plates:
            out += _plates(plates, references)
    points: Mapping[str, Callable[[Card, ElementReferences], Element]] = {
        "CONM2": _mass,
        "CELAS1": _spring,
        "CELAS2": _spring,
    }
    out += [points[card.name](card, references) for card in by.values() if card.name in points]
    return sorted(out, key=lambda element: element.number)


def _bar_property(card: Card, references: ElementReferences) -> BarProperty:
    if card.name == "CONROD":
        # EID, G1, G2, MID, A, J, C, NSM as PID, MID, A, J, C, NSM of a PROD
        fields = (card.fields[0], *card.fields[3:])
        return prod(Card("CONROD", fields, card.line), references.materials)
    bar = references.properties.get(card.integer(2, card.integer(1)))
    kinds = {"CBAR": ("PBAR", "PBARL"), "CBEAM": ("PBEAM",), "CROD": ("PROD",)}[card.name]
    if not isinstance(bar, BarProperty) or bar.name.split()[0] not in kinds:
        raise card.wrong(2, f"the number of a {' or '.join(kinds)} of this file")
    return bar


def _upright(card: Card, ends: tuple[int, int], references: ElementReferences) -> FloatArray:
    """Return the vector that turns a bar about its axis: of X1, X2, X3, or towards a grid point."""
    start, end = (np.array(references.places[point]) for point in ends)
    if card.name in ("CROD", "CONROD"):
        across = np.zeros(3)
        across[np.abs(end - start).argmin()] = 1.0  # arbitrary: a rod has no bending
        return across
    for at in (*range(9, 11), *range(11, 17)):
        card.must_be(at, (0.0,), "a pin or an offset")
    if card.text(8) and card.text(8).upper() not in ("GGG", "BGG", "GGO", "GOG", "GOO"):
        card.must_be(8, (0.0, 1.0, 2.0), "an offset vector in other axes")
    if card.text(5) and not card.text(6) and not card.text(7) and card.text(5).isdigit():
        return np.asarray(np.array(references.places[references.point(card, 5)]) - start)
    return np.array([card.real(at, 0.0) for at in (5, 6, 7)])


def _bars(cards: Sequence[Card], references: ElementReferences) -> list[Element]:
    ends = [tuple(references.point(card, at) for at in point_fields(card)) for card in cards]
    stated = [_bar_property(card, references) for card in cards]
    along = np.array([np.subtract(references.places[b], references.places[a]) for a, b in ends])
    for card, vector in zip(cards, along, strict=True):
        if np.linalg.norm(vector) < MODEL_FILE.min_bar_length:
            raise card.wrong(3, "two grid points apart")
    density = np.array([bar.material.density for bar in stated])
    area, torsion = np.array([bar.area for bar in stated]), np.array([bar.torsion for bar in stated])
    second = np.array([bar.second_moments for bar in stated])
    # a section's own polar moment; that of a rod, which has none, is its torsion constant
    polar = np.where(second.sum(axis=1) > 0, second.sum(axis=1), torsion)
    bars = SpatialBars(
        along=along,
        upright=np.array(
            [_upright(card, (a, b), references) for card, (a, b) in zip(cards, ends, strict=True)]
        ),
        modulus=np.array([bar.material.modulus for bar in stated]),
        shear_modulus=np.array([bar.material.shear_modulus for bar in stated]),
        area=area,
        second_moments=second,
        torsion=torsion,
        line_mass=density * area + [bar.more_mass for bar in stated],
        polar_mass=density * polar,
        shear_coefficients=np.array([bar.shear_coefficients for bar in stated]),
    )
    for card, axes in zip(cards, bar_axes(bars), strict=True):
        if not np.isfinite(axes).all():
            raise card.wrong(5, "a vector that does not lie along the bar")
    matrices = zip(*bars_in_space(bars), strict=True)
    return [
        Element(card.integer(1), bar.name, references.rows(pair), *matrices_of, bar.material.loss_factor)
        for card, pair, bar, matrices_of in zip(cards, ends, stated, matrices, strict=True)
    ]


def _plates(cards: Sequence[Card], references: ElementReferences) -> list[Element]:
    points = [tuple(references.point(card, at) for at in point_fields(card)) for card in cards]
    stated: list[PlateProperty] = []
    for card in cards:
        plate = references.properties.get(card.integer(2, card.integer(1)))
        if not isinstance(plate, PlateProperty):
            raise card.wrong(2, "the number of a PSHELL of this file")
        k = CORNERS[card.name]
        card.must_be(4 + k, (0.0,), "an offset ZOFFS")
        for at in range(9, 15):
            if card.text(at):
                raise card.wrong(at, "blank: thickness by corner is not read")
        stated.append(plate)
    corners = np.array([[references.places[point] for point in rim] for rim in points])
    _check_flat(cards, corners)
    thickness = np.array([plate_property.thickness for plate_property in stated])
    more = np.array([plate_property.more_mass for plate_property in stated])
    plates = SpatialPlates(
        corners=corners,
        thickness=thickness,
        modulus=np.array([plate_property.material.modulus for plate_property in stated]),
        density=np.array([plate_property.material.density for plate_property in stated]) + more / thickness,
        poisson_ratio=np.array([plate_property.material.poisson_ratio for plate_property in stated]),
    )
    out = []
    for card, rim, plate_property, mass, axial, bending in zip(
        cards, points, stated, *plates_in_space(plates), strict=True
    ):
        parts = axial * plate_property.membrane, bending * plate_property.bending
        out.append(
            Element(
                card.integer(1),
                plate_property.name,
                references.rows(rim),
                mass,
                *parts,
                plate_property.material.loss_factor,
            )
        )
    return out


def _check_flat(cards: Sequence[Card], corners: FloatArray) -> None:
    for card, fits in zip(cards, convex(corners), strict=True):
        if not fits:
            raise card.wrong(3, "corners round a convex shape, one way or the other")
    for card, off in zip(cards, warp(corners), strict=True):
        if off > INPUT.max_warp:
            raise card.wrong(3, f"corners in one plane, to {INPUT.max_warp:g} of its size")


def _mass(card: Card, references: ElementReferences) -> Element:
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
    point = references.point(card, 2)
    return Element(card.integer(1), "CONM2", references.rows([point]), matrix, np.zeros((6, 6)))


def _spring(card: Card, references: ElementReferences) -> Element:
    if card.name == "CELAS1":
        number = card.integer(2, card.integer(1))
        if number not in references.springs:
            raise card.wrong(2, "the number of a PELAS of this file")
        spring = references.springs[number]
        name, stiffness, loss = f"PELAS {number}", spring.real(2), spring.real(3, 0.0)
    else:
        name, stiffness, loss = "CELAS2", card.real(2), card.real(7, 0.0)
    if stiffness < 0 or loss < 0:
        raise card.wrong(2, "a stiffness and a loss factor >= 0")
    rows = []
    for at in point_fields(card):
        directions = components(card, at + 1)
        if len(directions) != 1:
            raise card.wrong(at + 1, "one of the digits 1 to 6")
        rows.append(references.row[references.point(card, at), directions[0]])
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

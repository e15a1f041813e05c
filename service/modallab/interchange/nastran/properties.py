"""Materials and properties of bulk data: cross-sections and plates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.interchange.nastran.deck import Card

STATIONS = ("YES", "YESA", "NO")  # of a station along a beam: whether stress is wanted there


@dataclass(frozen=True)
class Mat:
    """An isotropic material."""

    modulus: float  # N/m^2
    shear_modulus: float  # N/m^2
    poisson_ratio: float
    density: float  # kg/m^3
    loss_factor: float | None


@dataclass(frozen=True)
class BarProperty:
    """A cross-section with its material."""

    name: str
    material: Mat
    area: float  # m^2
    second_moments: tuple[float, float]  # m^4: I1, of bending in plane 1, and I2
    torsion: float  # m^4
    more_mass: float  # kg/m
    shear_coefficients: tuple[float, float]  # 0: does not shear


@dataclass(frozen=True)
class PlateProperty:
    """A thickness with its material."""

    name: str
    material: Mat
    thickness: float  # m
    membrane: bool
    bending: bool
    more_mass: float  # kg/m^2


def material(card: Card) -> Mat:
    """Return a MAT1; of E, G and nu two suffice."""
    is_given = [bool(card.text(at)) for at in (2, 3, 4)]
    if sum(is_given) < 2:
        raise card.wrong(2, "two of E, G and NU")
    for at in (2, 3):
        if card.text(at) and card.real(at) <= 0:
            raise card.wrong(at, "> 0")
    if is_given[0]:
        modulus = card.real(2)
        nu = card.real(4) if is_given[2] else modulus / (2 * card.real(3)) - 1
    else:
        nu = card.real(4)
        modulus = 2 * card.real(3) * (1 + nu)
    if not -0.99 <= nu < 0.5:
        raise card.wrong(4, "-0.99 to 0.5")
    shear = card.real(3) if is_given[1] else modulus / (2 * (1 + nu))
    density = _not_negative(card, 5)
    loss = _not_negative(card, 8) if card.text(8) else None
    return Mat(modulus, shear, nu, density, loss)


def _not_negative(card: Card, at: int) -> float:
    value = card.real(at, 0.0)
    if value < 0:
        raise card.wrong(at, ">= 0")
    return value


def _of(card: Card, at: int, materials: Mapping[int, Mat]) -> Mat:
    number = card.integer(at)
    if number not in materials:
        raise card.wrong(at, "a MAT1 of this file: " + (", ".join(map(str, list(materials)[:20])) or "none"))
    return materials[number]


def _sheared(card: Card, at: int, default: float) -> tuple[float, float]:
    """Return the shear coefficients of a field and the next; they need a cross-section area."""
    coefficients = card.real(at, default), card.real(at + 1, default)
    if min(coefficients) < 0:
        raise card.wrong(at, ">= 0")
    if max(coefficients) > 0 and card.real(3, 0.0) == 0:
        raise card.wrong(3, "> 0 of what shears")
    return coefficients


def pbar(card: Card, materials: Mapping[int, Mat]) -> BarProperty:
    """Return a PBAR; K1 and K2 left out or 0: no shear."""
    card.must_be(19, (0.0,), "a product of inertia I12")
    return BarProperty(
        f"PBAR {card.integer(1)}",
        _of(card, 2, materials),
        _not_negative(card, 3),
        (_not_negative(card, 4), _not_negative(card, 5)),
        _not_negative(card, 6),
        _not_negative(card, 7),
        _sheared(card, 17, 0.0),
    )


def pbeam(card: Card, materials: Mapping[int, Mat]) -> BarProperty:
    """Return a PBEAM of one section from end to end; K1 and K2 left out: 1.

    Lines behind the first two are stations along the beam, and then shear, inertia and offsets.
    """
    card.must_be(6, (0.0,), "a product of inertia I12")
    first = 9 if card.text(9).upper() in STATIONS else 17  # behind the points where stress is wanted
    while (kind := card.text(first).upper()) in STATIONS:
        _check_station(card, first)
        first += 16 if kind == "YES" else 8  # only YES has a line of such points
    for at in range(first + 2, first + 16):
        card.must_be(at, (0.0,), "a taper, warping or an offset of a beam")
    return BarProperty(
        f"PBEAM {card.integer(1)}",
        _of(card, 2, materials),
        _not_negative(card, 3),
        (_not_negative(card, 4), _not_negative(card, 5)),
        _not_negative(card, 7),
        _not_negative(card, 8),
        _sheared(card, first, 1.0),
    )


def _check_station(card: Card, first: int) -> None:
    """Raise unless a station has the section of the first end."""
    # SO, X/XB, A, I1, I2, I12, J, NSM against A, I1, I2, I12, J, NSM of the first end
    for offset in range(6):
        at, first_value = first + 2 + offset, card.real(3 + offset, 0.0)
        if card.text(at) and abs(card.real(at) - first_value) > 1e-6 * abs(first_value):
            raise card.wrong(at, "the section of the first end: tapered beams are not read")


def _rod(a: Sequence[float]) -> tuple[float, float, float, float]:
    area = np.pi * a[0] ** 2
    return area, area * a[0] ** 2 / 4, area * a[0] ** 2 / 4, area * a[0] ** 2 / 2


def _tube(a: Sequence[float]) -> tuple[float, float, float, float]:
    outer, inner = _rod(a[:1]), _rod(a[1:2])
    first, second, third, fourth = (float(x - y) for x, y in zip(outer, inner, strict=True))
    return first, second, third, fourth


def _bar(a: Sequence[float]) -> tuple[float, float, float, float]:
    width, height = a[:2]
    long, short = max(a[:2]), min(a[:2])
    ratio = short / long
    torsion = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))  # Roark, to 4 %
    return width * height, width * height**3 / 12, height * width**3 / 12, torsion


def _box(a: Sequence[float]) -> tuple[float, float, float, float]:
    width, height, horizontal, vertical = a[:4]
    w, h = width - 2 * vertical, height - 2 * horizontal
    around = 2 * horizontal * vertical * (width - vertical) ** 2 * (height - horizontal) ** 2
    torsion = around / (
        width * vertical + height * horizontal - vertical**2 - horizontal**2
    )  # Bredt, thin walls
    return (
        width * height - w * h,
        (width * height**3 - w * h**3) / 12,
        (height * width**3 - h * w**3) / 12,
        torsion,
    )


Shape = Callable[[Sequence[float]], tuple[float, float, float, float]]
SHAPES: Mapping[str, tuple[int, Shape]] = {
    "ROD": (1, _rod),
    "TUBE": (2, _tube),
    "BAR": (2, _bar),
    "BOX": (4, _box),
}


def pbarl(card: Card, materials: Mapping[int, Mat]) -> BarProperty:
    """Return a PBARL of one of `SHAPES`."""
    kind = card.text(4).upper()
    if kind not in SHAPES:
        raise card.wrong(4, ", ".join(SHAPES))
    count, shape = SHAPES[kind]
    sizes = [card.real(9 + i) for i in range(count)]
    for i, size in enumerate(sizes):
        if size < 0 or (size == 0 and i == 0):
            raise card.wrong(9 + i, "> 0")
    area, first_moment, second_moment, torsion = shape(sizes)
    if min(area, first_moment, second_moment, torsion) <= 0:
        raise card.wrong(9, "sizes that leave a section")
    name = f"PBARL {card.integer(1)}"
    more = _not_negative(card, 9 + count)
    return BarProperty(
        name, _of(card, 2, materials), area, (first_moment, second_moment), torsion, more, (0.0, 0.0)
    )


def prod(card: Card, materials: Mapping[int, Mat]) -> BarProperty:
    """Return a PROD: no bending."""
    return BarProperty(
        f"PROD {card.integer(1)}",
        _of(card, 2, materials),
        _not_negative(card, 3),
        (0.0, 0.0),
        _not_negative(card, 4),
        _not_negative(card, 6),
        (0.0, 0.0),
    )


def pshell(card: Card, materials: Mapping[int, Mat]) -> PlateProperty:
    """Return a PSHELL of one homogeneous material; MID1 left out: no membrane, MID2: no bending."""
    chosen = [at for at in (2, 4) if card.text(at)]
    if not chosen:
        raise card.wrong(2, "MID1 or MID2")
    plate_material = _of(card, chosen[0], materials)
    for at in (4, 6):
        if card.text(at) and _of(card, at, materials) != plate_material:
            raise card.wrong(at, "the material of MID1: others are not read")
    card.must_be(5, (1.0,), "another bending stiffness")
    card.must_be(7, (0.833333, 0.8333, 5 / 6), "another shear thickness")
    if card.text(11):
        raise card.wrong(11, "blank: coupling of membrane and bending is not read")
    thickness = card.real(3)
    if thickness <= 0:
        raise card.wrong(3, "> 0")
    name = f"PSHELL {card.integer(1)}"
    return PlateProperty(
        name, plate_material, thickness, bool(card.text(2)), bool(card.text(4)), _not_negative(card, 8)
    )


BARS: Mapping[str, Callable[[Card, Mapping[int, Mat]], BarProperty]] = {
    "PBAR": pbar,
    "PBARL": pbarl,
    "PBEAM": pbeam,
    "PROD": prod,
}


def by_number(cards: Sequence[Card], noun: str) -> dict[int, Card]:
    """Return cards by their first field.

    Raises
    ------
    InvalidInputError
        If two share a number.
    """
    cards_by_number: dict[int, Card] = {}
    for card in cards:
        number = card.integer(1)
        if not 1 <= number <= 999_999_999:
            raise card.wrong(1, "1 to 999999999")
        if number in cards_by_number:
            raise InvalidInputError(
                f"two {noun} have number {number}, in lines {cards_by_number[number].line} and {card.line}",
                field=f"{card.name} {number}",
                value=number,
                allowed="each number once",
            )
        cards_by_number[number] = card
    return cards_by_number

"""Units of FRFs in words, such as `g/N`, `(m/s^2)/lbf` or `mm/s/N`, and their factors to SI.

Factors of length and force: NIST Special Publication 811 (2008), appendix B.
"""

import re
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind

_INCH, _POUND, _GRAVITY = 0.0254, 0.45359237, 9.80665
_POUND_FORCE = _POUND * _GRAVITY
_LENGTH, _TIME, _MASS = (0, 1, 0), (0, 0, 1), (1, 0, 0)  # exponents of kg, m, s
_SPEED, _ACCELERATION, _FORCE = (0, 1, -1), (0, 1, -2), (1, 1, -2)
_SYMBOLS = {
    **dict.fromkeys(("m", "meter", "metre"), (1.0, _LENGTH)),
    "cm": (1e-2, _LENGTH),
    "mm": (1e-3, _LENGTH),
    **dict.fromkeys(("um", "µm", "μm", "micron"), (1e-6, _LENGTH)),
    "nm": (1e-9, _LENGTH),
    **dict.fromkeys(("in", "inch"), (_INCH, _LENGTH)),
    "ft": (12 * _INCH, _LENGTH),
    **dict.fromkeys(("mil", "mils"), (1e-3 * _INCH, _LENGTH)),
    **dict.fromkeys(("s", "sec"), (1.0, _TIME)),
    "ms": (1e-3, _TIME),
    "ips": (_INCH, _SPEED),
    **dict.fromkeys(("g", "gn", "g_n"), (_GRAVITY, _ACCELERATION)),
    "Gal": (1e-2, _ACCELERATION),
    "kg": (1.0, _MASS),
    "N": (1.0, _FORCE),
    "mN": (1e-3, _FORCE),
    "kN": (1e3, _FORCE),
    "MN": (1e6, _FORCE),
    **dict.fromkeys(("lbf", "lb", "lbs"), (_POUND_FORCE, _FORCE)),
    **dict.fromkeys(("kgf", "kp"), (_GRAVITY, _FORCE)),
    "ozf": (_POUND_FORCE / 16, _FORCE),
    "kip": (1e3 * _POUND_FORCE, _FORCE),
    "dyn": (1e-5, _FORCE),
    "1": (1.0, (0, 0, 0)),
}
_KINDS = {
    (-1, 0, 2): FrfKind.RECEPTANCE,
    (-1, 0, 1): FrfKind.MOBILITY,
    (-1, 0, 0): FrfKind.INERTANCE,
}
SI = {FrfKind.RECEPTANCE: "m/N", FrfKind.MOBILITY: "(m/s)/N", FrfKind.INERTANCE: "(m/s^2)/N"}
_TOKEN = re.compile(
    r"\s*(?:(1(?![0-9])|[A-Za-zµμ_]+)\s*(?:(?:\^|\*\*)?\s*(?:\(([+-]?[1-9])\)|([+-]?[1-9])))?|([()*/]))"
)
_PLAIN = str.maketrans({"²": "^2", "³": "^3", "⁻": "-", "¹": "1", "·": "*", "⋅": "*", "[": "(", "]": ")"})
_MAX_LENGTH = 40


@dataclass(frozen=True)
class FrfUnit:
    """Unit of FRFs: a motion per force."""

    kind: FrfKind
    response: float
    """SI units of one unit of the response."""
    force: float
    """N of one unit of the force."""


@dataclass(frozen=True)
class _Product:
    """Product of units: factors of forces and of everything else, exponents of kg, m and s."""

    other: float = 1.0
    force: float = 1.0
    exponents: tuple[int, ...] = (0, 0, 0)

    def times(self, factor: "_Product", power: int) -> "_Product":
        """Return the product with a factor to a power."""
        return _Product(
            self.other * factor.other**power,
            self.force * factor.force**power,
            tuple(a + power * b for a, b in zip(self.exponents, factor.exponents, strict=True)),
        )


def frf_unit(text: str) -> FrfUnit:
    """Return the unit of FRFs that a text names.

    Parameters
    ----------
    text
        A motion per force: `g/N`, `(m/s^2)/lbf`, `mm/s/N`, `m/N`, `1/kg`. `g` is standard gravity.

    Raises
    ------
    InvalidInputError
        If the text is no unit, or no displacement, velocity or acceleration per force.
    """
    plain = text.translate(_PLAIN)
    tokens = _tokens(plain) if len(plain) <= _MAX_LENGTH else None
    product = None if tokens is None else _product(tokens)
    if product is None or tokens:
        raise _refusal(f"{text[:_MAX_LENGTH]!r} is no unit", text)
    if product.exponents not in _KINDS:
        raise _refusal(f"{text!r} is no displacement, velocity or acceleration per force", text)
    return FrfUnit(_KINDS[product.exponents], product.other, 1 / product.force)


def _tokens(text: str) -> list[re.Match[str]] | None:
    """Return symbols with exponents, and signs; None where there is anything else."""
    position, tokens = 0, []
    text = text.strip()
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            return None
        tokens.append(match)
        position = match.end()
    return tokens


def _product(tokens: list[re.Match[str]]) -> _Product | None:
    """Return the product at the beginning of a list of tokens, which are removed; None: there is none."""
    product, power = _Product(), 1
    while True:
        factor = _factor(tokens)
        if factor is None:
            return None
        product = product.times(factor, power)
        if not tokens or tokens[0][4] == ")":
            return product
        power = -1 if tokens[0][4] == "/" else 1
        if tokens[0][4] in ("*", "/"):
            tokens.pop(0)


def _factor(tokens: list[re.Match[str]]) -> _Product | None:
    token = tokens.pop(0) if tokens else None
    if token is not None and token[1] in _SYMBOLS:
        size, exponents = _SYMBOLS[token[1]]
        is_force = exponents == _FORCE
        unit = _Product(1.0 if is_force else size, size if is_force else 1.0, exponents)
        return _Product().times(unit, int(token[2] or token[3] or 1))
    if token is None or token[4] != "(":
        return None
    product = _product(tokens)
    if product is not None and tokens and tokens[0][4] == ")":
        tokens.pop(0)
        return product
    return None


def _refusal(message: str, text: str) -> InvalidInputError:
    allowed = "a motion per force, such as g/N, (m/s^2)/lbf, mm/s/N, m/N"
    return InvalidInputError(message, field="unit", value=text[:_MAX_LENGTH], allowed=allowed)

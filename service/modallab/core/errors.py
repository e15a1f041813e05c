"""Errors that the numerics raise deliberately."""

import math
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any, TypeAlias

JsonValue: TypeAlias = "str | float | Sequence[JsonValue] | Mapping[str, JsonValue] | None"


class ModalLabError(Exception):
    """Base of every error raised on purpose: a stable code, a message, values of JSON.

    Errors know nothing of HTTP; `api.problems` gives each class its status. `context` names the
    `field`, the `value` and the values `allowed` wherever one input is to blame: a number, a list, the
    mapping of `bounds`, or a requirement in words.
    """

    code = "modallab"

    def __init__(self, message: str, **context: JsonValue) -> None:
        super().__init__(message)
        self.context: dict[str, Any] = {name: _plain(value) for name, value in context.items()}


def bounds(
    minimum: float | None = None,
    maximum: float | None = None,
    *,
    exclusive_minimum: float | None = None,
    exclusive_maximum: float | None = None,
    unit: str = "",
) -> dict[str, JsonValue]:
    """Return the bounds of a number, named as in JSON Schema, and its unit.

    Parameters
    ----------
    minimum, maximum
        Bounds that are allowed themselves; None where there is none.
    exclusive_minimum, exclusive_maximum
        Bounds that are not allowed themselves.
    unit
        SI unit, or the things counted; empty, `1` or `-` of a ratio.
    """
    numbers = {
        "minimum": minimum,
        "exclusiveMinimum": exclusive_minimum,
        "maximum": maximum,
        "exclusiveMaximum": exclusive_maximum,
    }
    stated: dict[str, JsonValue] = {name: value for name, value in numbers.items() if value is not None}
    return stated if unit in ("", "1", "-") else stated | {"unit": unit}


def sentence(error: ModalLabError) -> str:
    """Return the message of an error with the field at fault, its value and the values allowed."""
    names = [name for name in ("field", "value", "allowed") if error.context.get(name) not in ("", None)]
    details = "; ".join(f"{name}: {in_words(error.context[name])}" for name in names)
    return f"{error} ({details})" if details else str(error)


def in_words(value: Any) -> str:
    """Return a value of an error's context in words: `1 to 6`, `more than 0 Hz`, `lscf, dobson`."""
    if isinstance(value, Mapping):
        named = (f"{name}: {in_words(item)}" for name, item in value.items())
        return _interval(value) if value.keys() & _BOUNDS else ", ".join(named)
    if isinstance(value, (list, tuple)):
        return ", ".join(map(in_words, value)) or "none"
    if value is None:
        return "null"
    return f"{value:g}" if isinstance(value, float) else str(value)


_BOUNDS = {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}


def _interval(interval: Mapping[str, Any]) -> str:
    stated = {name: in_words(value) for name, value in interval.items()}
    unit = f" {stated['unit']}" if "unit" in stated else ""
    if {"minimum", "maximum"} <= stated.keys():
        return f"{stated['minimum']} to {stated['maximum']}{unit}"
    words = {"minimum": "at least", "exclusiveMinimum": "more than"}
    words |= {"maximum": "at most", "exclusiveMaximum": "less than"}
    return " and ".join(f"{word} {stated[name]}" for name, word in words.items() if name in stated) + unit


def _plain(value: Any) -> Any:
    """Return a value as JSON has it, of Python's own types."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value) if math.isfinite(value) else str(float(value))
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return str(value)


class InvalidInputError(ModalLabError, ValueError):
    """Invalid input: wrong shape, value out of bounds, unknown name."""

    code = "invalid_input"


class UnknownDofError(InvalidInputError):
    """A degree of freedom that the structure does not have."""

    code = "unknown_dof"


class StructureError(InvalidInputError):
    """A structure that cannot be analysed: disconnected, fully constrained, of negative section."""

    code = "structure"


class NotFoundError(ModalLabError, LookupError):
    """Nothing is stored under that id."""

    code = "not_found"


class NoModeInBandError(ModalLabError):
    """The band handed to an extraction method holds no resonance."""

    code = "no_mode_in_band"


class UnderdeterminedError(ModalLabError):
    """Fewer equations than unknowns, or modes that pair with nothing."""

    code = "underdetermined"


class DivergedError(ModalLabError):
    """An iteration diverged: it left the region where its equations hold."""

    code = "diverged"


class MissingExtraError(ModalLabError):
    """The request needs an optional dependency that is not installed."""

    code = "missing_extra"


class CancelledError(ModalLabError):
    """The caller asked for the work to stop."""

    code = "cancelled"

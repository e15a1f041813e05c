"""Errors of validation by field, in the names that the body itself has."""

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import TypeAdapter, ValidationError

from modallab.api.limits import REPLY
from modallab.api.schema_walk import property_names, suggestion
from modallab.core.errors import InvalidInputError

Json = Any
Place = Sequence[str | int]
# Names that the body may have at a place of pydantic's.
NamesAt = Callable[[Place], Sequence[str]]

_KEY = "[key]"  # pydantic's mark of a name in a mapping that is wrong itself
# What pydantic calls a bound, and what JSON Schema does.
_BOUNDS = {
    "ge": "minimum",
    "le": "maximum",
    "gt": "exclusiveMinimum",
    "lt": "exclusiveMaximum",
    "pattern": "pattern",
}
_LENGTHS = {
    "too_short": ("min_length", "minItems"),
    "too_long": ("max_length", "maxItems"),
    "string_too_short": ("min_length", "minLength"),
    "string_too_long": ("max_length", "maxLength"),
}


@dataclass(frozen=True)
class Fault:
    """One field that is wrong: its name, why, the value sent and the values allowed, as JSON has them."""

    field: str
    message: str
    value: Json
    allowed: Json


def faults(
    errors: Iterable[Mapping[str, Any]], body: Any, within: Sequence[str], names_at: NamesAt = lambda _: ()
) -> list[Fault]:
    """Return the faults of a body, the most telling first.

    Pydantic reports every alternative of a union. The alternative that agrees with the body farthest is
    the one that was meant, and an error of value says more than one of type.

    Parameters
    ----------
    errors
        From pydantic, their places in the body.
    body
        As it was sent; None if that is not known.
    within
        Path of the body itself, with which names begin.
    names_at
        Names allowed at a place, for fields that do not exist.
    """
    placed = [(_path(error, body), error) for error in errors]
    placed.sort(key=lambda pair: (-len(pair[0]), *_vagueness(pair[1], names_at)))
    return [_fault(".".join(map(str, (*within, *path))), error, names_at) for path, error in placed]


def _fault(field: str, error: Mapping[str, Any], names_at: NamesAt) -> Fault:
    message = error["msg"].removeprefix("Value error, ")  # pydantic's prefix of our own words
    allowed = _allowed_values(error)
    if error["type"] == "extra_forbidden":
        *place, name = error["loc"]
        allowed = list(names_at(place))
        message = f"there is no such field{suggestion(str(name), allowed)}"
    return Fault(field, message, as_json(error.get("input")), allowed)


def adapter_names(adapter: TypeAdapter[Any]) -> NamesAt:
    """Return the names that a type allows at a place."""
    schema = adapter.json_schema()
    return lambda place: property_names(schema, schema.get("$defs", {}), place)


def wrong_json(error: ValidationError, adapter: TypeAdapter[Any], text: str, name: str) -> InvalidInputError:
    """Return the error of a form's field whose JSON is refused."""
    try:
        body = json.loads(text)
    except ValueError:
        body = None
    first, *_ = faults(error.errors(), body, (name,), adapter_names(adapter))
    return InvalidInputError(
        f"{first.field}: {first.message}", field=first.field, value=text[: REPLY.value_characters]
    )


def as_json(value: Any) -> Json:
    """Return a refused value as JSON has it; a long one, or one that is no JSON, as the start of its text."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, str):
        return value[: REPLY.value_characters]
    try:
        text = json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        return str(value)[: REPLY.value_characters]
    return value if len(text) <= REPLY.value_characters else text[: REPLY.value_characters]


def _allowed_values(error: Mapping[str, Any]) -> Json:
    """Return a list of names, or the broken bound by its name in JSON Schema; None where neither is known."""
    context: Mapping[str, Any] = error.get("ctx") or {}
    expected = context.get("expected") or context.get("expected_tags")
    if isinstance(expected, str) and (names := re.findall(r"'([^']*)'", expected)):
        return names
    if error["type"] in _LENGTHS:
        name, keyword = _LENGTHS[error["type"]]
        return {keyword: context.get(name)}
    bounds = {keyword: context[name] for name, keyword in _BOUNDS.items() if name in context}
    return bounds or None


def _path(error: Mapping[str, Any], body: Any) -> tuple[str | int, ...]:
    """Return the place of a fault, without the names that pydantic gives the types it tried."""
    if body is None:
        return tuple(error["loc"])
    path: list[str | int] = []
    for i, part in enumerate(error["loc"]):
        last = i == len(error["loc"]) - 1
        is_key = isinstance(body, Mapping) and part in body
        is_index = isinstance(part, int)
        if is_key or is_index or part == _KEY or _is_tag(part, body) or (last and error["type"] == "missing"):
            path.append(part)
        if is_key or (is_index and isinstance(body, Sequence) and part < len(body)):
            body = body[part]
    return tuple(path)


def _is_tag(part: str, body: Any) -> bool:
    """Return whether a body names by this word the alternative of a union that it is."""
    return isinstance(body, Mapping) and any(
        value == part for value in body.values() if isinstance(value, str)
    )


def _vagueness(error: Mapping[str, Any], names_at: NamesAt) -> tuple[bool, bool]:
    """Return a sort key: errors of type last, a misspelt field before the one that is missing for it."""
    kind: str = error["type"]
    *place, name = error["loc"] or ("",)
    misspelt = kind == "extra_forbidden" and suggestion(str(name), names_at(place)) != ""
    return kind == "literal_error" or kind.endswith("_type"), not misspelt

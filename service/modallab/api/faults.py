"""What is wrong with a body, field by field, in the names that the body itself has."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from modallab.core.errors import InvalidInputError

_SHOWN = 200  # characters of a refused value that are shown
_KEY = "[key]"  # pydantic's mark of a name in a mapping that is wrong itself


@dataclass(frozen=True)
class Fault:
    """One field that is wrong."""

    field: str
    message: str
    value: str


def faults(errors: Iterable[Mapping[str, Any]], body: Any, within: Sequence[str]) -> list[Fault]:
    """Return what is wrong, what says most first.

    Of a field that may be one of several things each is a try of its own. The try that came farthest into
    the body says what is amiss, and one that stumbles over a value less than one over its type.

    Parameters
    ----------
    errors
        From pydantic, their places in the body.
    body
        As it was sent; None if that is not known.
    within
        What the body is a part of, by which names begin.
    """
    found = [(_path(error, body), error) for error in errors]
    found.sort(key=lambda one: (-len(one[0]), _of_another_type(one[1])))
    return [
        Fault(
            field=".".join(map(str, (*within, *path))),
            message=error["msg"].removeprefix("Value error, "),  # pydantic's word for ours
            value=repr(error.get("input"))[:_SHOWN],
        )
        for path, error in found
    ]


def wrong_json(error: ValidationError, text: str, name: str, *, allowed: str) -> InvalidInputError:
    """Return the error of a form's field that holds other JSON than is allowed."""
    try:
        body = json.loads(text)
    except ValueError:
        body = None
    fault, *_ = faults(error.errors(), body, (name,))
    return InvalidInputError(
        f"{fault.field}: {fault.message}", field=fault.field, value=text[:_SHOWN], allowed=allowed
    )


def _path(error: Mapping[str, Any], body: Any) -> tuple[str | int, ...]:
    """Return where a fault is, without what pydantic calls the types that it tried."""
    if body is None:
        return tuple(error["loc"])
    path: list[str | int] = []
    for i, part in enumerate(error["loc"]):
        last = i == len(error["loc"]) - 1
        named = isinstance(body, Mapping) and part in body
        counted = isinstance(part, int)
        if named or counted or part == _KEY or _is_tag(part, body) or (last and error["type"] == "missing"):
            path.append(part)
        if named or (counted and isinstance(body, Sequence) and part < len(body)):
            body = body[part]
    return tuple(path)


def _is_tag(part: str, body: Any) -> bool:
    """Return whether a body says by this word which of several things it is."""
    return isinstance(body, Mapping) and any(
        value == part for value in body.values() if isinstance(value, str)
    )


def _of_another_type(error: Mapping[str, Any]) -> bool:
    kind: str = error["type"]
    return kind == "literal_error" or kind.endswith("_type")

"""Flags of a command, derived from the keywords of a job in `modallab_client.options`."""

import json
from collections import abc
from collections.abc import Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import click

from modallab_cli.arguments import Command, Decorator
from modallab_client.errors import InvalidInputError

_PLAIN = (bool, int, float, str)


def with_keywords(keywords: type, *, without: Sequence[str] = ()) -> Decorator:
    """Return a decorator that gives a command each keyword of a job as a flag, for its own `**flags`.

    Parameters
    ----------
    keywords
        A TypedDict of `modallab_client.options`, written from the options of the service.
    without
        Keywords that the command does not have.
    """
    hints = {name: hint for name, hint in _hints(keywords).items() if name not in without}
    return with_flags([_flag(name, hint) for name, hint in hints.items()])


def with_flags(flags: Sequence[Decorator]) -> Decorator:
    """Return a decorator that gives a command flags, in their order."""

    def decorate(command: Command) -> Command:
        for flag in reversed(flags):
            command = flag(command)
        return command

    return decorate


def keywords_of(keywords: type, flags: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keywords of a job that flags state; those left out have the service's defaults.

    Raises
    ------
    InvalidInputError
        If a flag whose value is JSON holds none.
    """
    hints = _hints(keywords)
    return {
        name: _value(name, hints[name], value) for name, value in flags.items() if value not in (None, ())
    }


def _hints(keywords: type) -> dict[str, Any]:
    return get_type_hints(keywords, include_extras=True)


def _flag(name: str, hint: Any) -> Decorator:
    """Return a flag with its type and help."""
    described, *texts = get_args(hint)
    repeated = _items(described) is not None
    long = f"--{name.replace('_', '-')}"
    names = dict.fromkeys((long, long.removesuffix("s") if repeated else long))
    notes = ["may be repeated"] if repeated else []
    notes += ["JSON"] if _is_json(described) else []
    text = f"{texts[0]} ({'; '.join(notes)})" if notes else texts[0]
    kind = str if repeated else _plain(described)
    if kind is bool:
        return click.option(f"{long}/{long.replace('--', '--no-')}", name, default=None, help=text)
    return click.option(*names, name, type=kind, multiple=repeated, help=text)


def _value(name: str, hint: Any, value: Any) -> Any:
    described = get_args(hint)[0]
    if not _is_json(described):
        return value
    try:
        return [json.loads(text) for text in value] if isinstance(value, tuple) else _name_or_json(value)
    except ValueError:
        raise InvalidInputError(f"--{name.replace('_', '-')}: not JSON: {value}") from None


def _name_or_json(text: str) -> Any:
    return json.loads(text) if text.startswith("{") else text


def _members(hint: Any) -> list[Any]:
    """Return the types of a union without None, or the one type."""
    members = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return [member for member in members if member is not NoneType]


def _items(hint: Any) -> Any:
    """Return the type of the entries of a sequence; None of anything else."""
    for member in _members(hint):
        if get_origin(member) is abc.Sequence:
            return get_args(member)[0]
    return None


def _is_json(hint: Any) -> bool:
    item = _items(hint)
    kinds = _members(hint if item is None else item)
    return any(get_origin(kind) in (abc.Mapping, abc.Sequence) for kind in kinds)


def _plain(hint: Any) -> Any:
    return next((kind for kind in _PLAIN if kind in _members(hint)), str)

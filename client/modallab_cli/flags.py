"""Flags of a command, derived from an options dataclass."""

from collections.abc import Mapping, Sequence
from dataclasses import Field, fields
from typing import Any, get_args, get_origin, get_type_hints

import click

from modallab.core.errors import bounds, in_words
from modallab.core.options import Options, OptionSpec
from modallab_cli.arguments import Decorator
from modallab_cli.keywords import with_flags


def with_options(options: type[Options], *, without: Sequence[str] = ()) -> Decorator:
    """Return a decorator that gives a command each option as a flag, for its own `**flags`.

    Sequences and nested options may be repeated; their flag has the singular as a second name. A flag left
    out is None: the dataclass gives the default.

    Parameters
    ----------
    without
        Options that the command does not have.
    """
    hints = get_type_hints(options)
    names = options.specs().keys() - set(without)
    declared = [f for f in fields(options) if f.name in names]  # type: ignore[arg-type]
    return with_flags([_flag(hints[f.name], options.specs()[f.name], f) for f in declared])


def _flag(hint: Any, spec: OptionSpec, declared: Field[Any]) -> Decorator:
    """Return a flag: its type, its names, and the help with unit, bounds and default."""
    nested = _nested(hint)
    repeated = nested is not None or _is_sequence(hint)
    kind: Any = str if repeated else next(h for h in (*get_args(hint), hint) if isinstance(h, type))
    name = f"--{declared.name.replace('_', '-')}"
    names = dict.fromkeys((name, name.removesuffix("s") if repeated else name))
    limits = bounds(spec.lower, spec.upper, exclusive_minimum=spec.exclusive_minimum, unit=spec.unit)
    unit = "" if spec.unit in ("", "1", "-") else spec.unit
    allowed = in_words(limits) if limits.keys() - {"unit"} else unit
    default = declared.metadata["null_name"] if spec.default is None else spec.default
    shown = "" if nested is not None or default in ("", (), None) else f"default: {default}"
    form = _form(nested) if nested is not None else "lower:upper" if _is_sequence_of_pairs(hint) else ""
    repeat = "may be repeated" if repeated else ""
    details = "; ".join(text for text in (allowed, *spec.choices, form, shown, repeat) if text)
    text = f"{spec.doc} ({details})" if details else spec.doc
    if kind is bool:
        return click.option(f"{name}/{name.replace('--', '--no-')}", declared.name, default=None, help=text)
    kind = str if issubclass(kind, str) else kind
    unset = () if repeated else None  # the service has the defaults
    return click.option(*names, declared.name, type=kind, multiple=repeated, default=unset, help=text)


def request_of(options: type[Options], flags: Mapping[str, Any]) -> dict[str, Any]:
    """Return the part of a request's body that flags stand for; options left out have their defaults.

    Raises
    ------
    click.BadParameter
        If a value of a nested option cannot be read.
    """
    hints = get_type_hints(options)
    request: dict[str, Any] = {}
    for name, value in flags.items():
        nested = _nested(hints[name])
        if value not in (None, (), []):
            choices = options.specs()[name].choices
            request[name] = (
                value[0]
                if nested is not None and len(value) == 1 and value[0] in choices
                else _nested_values(name, nested, value)
                if nested is not None
                else [pair(name, text) for text in value]
                if _is_sequence_of_pairs(hints[name])
                else list(value)
                if isinstance(value, tuple)
                else value
            )
    return request


def _nested_values(name: str, options: type[Options], texts: Sequence[str]) -> dict[str, Any]:
    """Return nested options, each given as `name=value`, or as a value that only one of them takes."""
    hints = get_type_hints(options)
    values: dict[str, Any] = {}
    for text in texts:
        field, has_name, value = text.partition("=")
        if not has_name:
            field, value = _field_of(options, text) or "", text
        number = _number(value)
        repeated = _is_sequence(hints.get(field))
        if not field or (number is None and not repeated) or (field in values and not repeated):
            raise click.BadParameter(
                f"{text!r} is not {_form(options)}", param_hint=f"--{name.replace('_', '-')}"
            )
        values[field] = [*values.get(field, []), value] if repeated else number
    return values


def _field_of(options: type[Options], text: str) -> str | None:
    """Return the only nested option that takes a number, or else a name; None if there is none or more."""
    is_number = _number(text) is not None
    hints = get_type_hints(options)
    names = [name for name in options.specs() if _is_sequence(hints[name]) is not is_number]
    return names[0] if len(names) == 1 else None


def _form(options: type[Options]) -> str:
    """Return how nested options are written, in words."""
    hints = get_type_hints(options)
    names = [name for name in options.specs() if not _is_sequence(hints[name])]
    names_text = f"name=value of {', '.join(names)}"
    if len(names) > 1:
        return names_text
    lists = [name for name in options.specs() if _is_sequence(hints[name])]
    return " or ".join([f"one {names[0]}", *lists])


def _nested(hint: Any) -> type[Options] | None:
    members = (hint, *get_args(hint))
    return next((h for h in members if isinstance(h, type) and issubclass(h, Options)), None)


def _is_sequence(hint: Any) -> bool:
    return any(get_origin(member) is tuple for member in (hint, *get_args(hint)))


def _is_sequence_of_pairs(hint: Any) -> bool:
    """Return whether a sequence has pairs of numbers as entries."""
    sequences = [member for member in (hint, *get_args(hint)) if get_origin(member) is tuple]
    return any(get_origin(entry) is tuple for member in sequences for entry in get_args(member)[:1])


def pair(name: str, text: str) -> list[float]:
    """Return the numbers of `lower:upper`."""
    numbers = [_number(part) for part in text.split(":")]
    found = [number for number in numbers if number is not None]
    if len(numbers) != 2 or len(found) != 2:
        raise click.BadParameter(f"{text!r} is not lower:upper", param_hint=f"--{name}")
    return found


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

"""Replies derived from domain types: one pydantic model a frozen dataclass, described by its docstrings."""

import ast
import inspect
import math
import operator
import re
import sys
import types
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, create_model

from modallab.api.thinning import numbers
from modallab.api.wire import ChannelsAt, DofsAt, MembersAt, Reply, StoredEntry, place_out
from modallab.core.dof import Dof
from modallab.core.options import Options
from modallab.core.place import Place
from modallab.core.reply import Axes, LeftOutIfEmpty, MayBeNan
from modallab.store.base import Entry

# Derived models have their descriptions already; pydantic would search the callers' source for each.
_NO_SOURCE = ConfigDict(use_attribute_docstrings=False)


class DerivedReply(Reply):
    """Base of derived replies that are part of a resource."""

    model_config = _NO_SOURCE


class StoredReply(StoredEntry):
    """Base of derived replies of stored resources."""

    model_config = _NO_SOURCE

    @classmethod
    def of(cls, value: object, entry: Entry, **added: Any) -> Any:
        """Return the reply of a stored value.

        Parameters
        ----------
        value
            Of the domain type that this reply is derived from.
        entry
            Its entry in the store.
        added
            Values of the fields that the domain type does not have.
        """
        names = cls.model_fields.keys() - StoredEntry.model_fields.keys() - added.keys()
        read = {name: getattr(value, name) for name in names}
        return cls.model_validate({**StoredEntry.fields(entry), **read, **added}, from_attributes=True)


def stored_reply(
    domain: type, name: str, *, leave_out: tuple[str, ...] = (), **added: tuple[Any, str]
) -> type[StoredReply]:
    """Return the reply model of a stored domain type.

    Parameters
    ----------
    domain
        A frozen dataclass; its docstring and attribute docstrings become descriptions.
    name
        Component name in the OpenAPI document.
    leave_out
        Fields that the reply does not have, because they are stored under their own ids, or are served in the
        entry of the store or by another route.
    added
        Further fields, or other types of fields, as `name=(type, description)`.
    """
    definitions = _definitions(domain, leave_out, added)
    model: type[StoredReply] = create_model(
        name, __base__=StoredReply, __doc__=inspect.getdoc(domain), **definitions
    )
    return model


@cache
def reply_of(domain: type) -> type[Reply]:
    """Return the reply model of a domain type that is part of a resource."""
    return reply(domain, domain.__name__)


def replies_of(domain: type) -> Any:
    """Return the type of a list of replies."""
    return list[reply_of(domain)]  # type: ignore[misc]


def reply(
    domain: type, name: str, *, leave_out: tuple[str, ...] = (), **added: tuple[Any, str]
) -> type[Reply]:
    """Return the reply model of a domain type that is part of a resource; parameters as of `stored_reply`."""
    definitions = _definitions(domain, leave_out, added)
    model: type[Reply] = create_model(
        name, __base__=DerivedReply, __doc__=inspect.getdoc(domain), **definitions
    )
    return model


def _definitions(
    domain: type, leave_out: tuple[str, ...], added: Mapping[str, tuple[Any, str]]
) -> dict[str, Any]:
    """Return the fields of a derived model by name: type and description."""
    hints = get_type_hints(domain, include_extras=True)
    docs = attribute_docs(domain)
    definitions = {}
    for field in fields(domain):
        hint = None if field.name in leave_out else wire_type(hints[field.name])
        if hint is not None:
            told = docs.get(field.name) or _declared(field)
            definitions[field.name] = (hint, Field(description=told, **_default(hints[field.name])))
    return definitions | {name: (hint, Field(description=text)) for name, (hint, text) in added.items()}


def _default(hint: Any) -> dict[str, Any]:
    """Return the default of a field of a reply that is left out where it is empty; nothing for others."""
    empty = get_origin(hint) is Annotated and LeftOutIfEmpty() in get_args(hint)[1:]
    return {"default": (), "exclude_if": operator.not_} if empty else {}


def _declared(field: Any) -> str | None:
    """Return the description of a field that is declared by `core.parameters` or `core.options`."""
    spec = field.metadata.get("spec") or field.metadata.get("option")
    return None if spec is None else f"{spec.unit}, {spec.doc}." if spec.unit else f"{spec.doc}."


@cache
def _class_bodies(module: str) -> dict[str, list[ast.stmt]]:
    """Return the statements of each top-level class of a module, which is parsed once."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)}


@cache
def attribute_docs(domain: type) -> dict[str, str]:
    """Return the attribute docstrings of a dataclass and its bases: string literals below its fields."""
    docs: dict[str, str] = {}
    for cls in reversed(domain.__mro__):
        if not is_dataclass(cls):
            continue
        body = _class_bodies(cls.__module__).get(cls.__name__, [])
        for statement, following in pairwise(body):
            match statement, following:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str(text))),
                ):
                    docs[name] = re.sub(r"\b(nan|None)\b", "null", " ".join(text.split()))
    return docs


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _pair(value: Any) -> Any:
    return [_finite(value.real), _finite(value.imag)] if isinstance(value, complex) else value


def _nested(value: Any) -> Any:
    return numbers(value) if isinstance(value, np.ndarray) else value


def _mapping(value: Any) -> Any:
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


# Formats by which generators tell arrays from lists, complex numbers from pairs, and keys that are numbers.
_COMPLEX = Field(json_schema_extra={"format": "complex"})
_ARRAY = Field(json_schema_extra={"format": "array"})
_NUMBERED = Field(json_schema_extra={"propertyNames": {"pattern": "^[0-9]+$"}})

_PAIR = tuple[float | None, float | None]
_SCALARS: Mapping[Any, Any] = {
    Dof: Annotated[str, BeforeValidator(str)],
    complex: Annotated[_PAIR, BeforeValidator(_pair), _COMPLEX],
}
PlaceOut = str | DofsAt | MembersAt | ChannelsAt | None
_OPTIONS = Annotated[dict[str, Any], BeforeValidator(_mapping)]
_MAYBE = Annotated[float | None, BeforeValidator(_finite)]


def wire_type(hint: Any) -> Any:  # noqa: PLR0911 - one return for each kind of type
    """Return the wire's type of an annotation; None of arrays that only `/arrays` has."""
    marks: tuple[Any, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *metadata = get_args(hint)
        marks = tuple(metadata)
    if any(isinstance(mark, MayBeNan) for mark in marks):
        return _MAYBE
    if hint == Place:
        return Annotated[PlaceOut, BeforeValidator(place_out)]
    origin = get_origin(hint)
    if origin is np.ndarray:
        return _array(hint, marks)
    if origin in (Union, types.UnionType):
        return _union(get_args(hint), marks)
    if origin is Literal:
        return hint
    if origin is not None:
        return _container(origin, get_args(hint))
    if hint in _SCALARS:
        return _SCALARS[hint]
    if isinstance(hint, type) and issubclass(hint, Options):
        return _OPTIONS
    if is_dataclass(hint) and isinstance(hint, type):
        return reply_of(hint)
    return hint


def _array(hint: Any, marks: tuple[Any, ...]) -> Any:
    """Return nested lists of a marked array, None of any other."""
    axes = next((mark.count for mark in marks if isinstance(mark, Axes)), None)
    if axes is None:
        return None
    (scalar,) = get_args(get_args(hint)[1])
    pair = Annotated[_PAIR, _COMPLEX]
    item: Any = {"f": float | None, "c": pair, "i": int, "b": bool, "u": int}[np.dtype(scalar).kind]
    for _ in range(axes):
        item = Annotated[list[item], _ARRAY]
    return Annotated[item, BeforeValidator(_nested)]


def _union(options: tuple[Any, ...], marks: tuple[Any, ...]) -> Any:
    parts = [option for option in options if option is not type(None)]
    if len(parts) == 1:
        inner = wire_type(Annotated[parts[0], *marks] if marks else parts[0])
        return None if inner is None else inner | None if not _annotated(inner) else _optional(inner)
    alternatives = [wire_type(option) for option in parts]
    if None in alternatives:
        return None
    union: Any = Union[tuple(alternatives)]  # noqa: UP007
    return union | None if len(parts) < len(options) else union


def _annotated(hint: Any) -> bool:
    return get_origin(hint) is Annotated


def _optional(hint: Any) -> Any:
    """Return an annotated type or None; the validator is not run on None."""
    inner, *validators = get_args(hint)
    (validate,) = (v.func for v in validators if isinstance(v, BeforeValidator))
    shape = [v for v in validators if not isinstance(v, BeforeValidator)]

    def unless_none(value: Any, validate: Any = validate) -> Any:
        return None if value is None else validate(value)

    inner = Annotated[inner, *shape] if shape else inner
    return Annotated[inner | None, BeforeValidator(unless_none)]


def _container(origin: Any, options: tuple[Any, ...]) -> Any:
    if issubclass(origin, Mapping):
        key, item = (wire_type(option) for option in options)
        if item is None:
            return None
        table: Any = dict[key, item]  # type: ignore[valid-type]
        return Annotated[table, _NUMBERED] if key is int else table
    if origin is tuple and not (len(options) == 2 and options[1] is Ellipsis):
        return tuple[tuple(wire_type(option) for option in options)]  # type: ignore[misc]
    item = wire_type(options[0])
    return None if item is None else list[item]  # type: ignore[valid-type]

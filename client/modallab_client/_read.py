"""Replies as the generated result types: by their annotations, numbers in lists as read-only numpy arrays."""

import types
from collections.abc import Hashable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")


def read_as(cls: type[T], data: Mapping[str, Any], **arrays: Any) -> T:
    """Return a reply as a generated type.

    Parameters
    ----------
    cls
        A dataclass of `modallab_client._generated.models`.
    data
        The JSON object; fields that the client does not know are ignored.
    arrays
        Fields that another request brought.

    Raises
    ------
    KeyError, TypeError, ValueError
        If a field is missing or of another type.
    """
    kind: Any = cls
    hints = _hints(kind)
    values = dict(arrays)
    for field in fields(kind):
        if field.name in arrays:
            continue
        if field.name in data:
            values[field.name] = _value(hints[field.name], data[field.name])
        elif field.name not in values and field.default is MISSING and field.default_factory is MISSING:
            values[field.name] = _absent(field.name, hints[field.name])
    return cls(**values)


@cache
def _hints(cls: Hashable) -> dict[str, Any]:
    kind: Any = cls
    return get_type_hints(kind)


def _absent(name: str, hint: Any) -> Any:
    """Return the value of a field that an earlier service did not have: null or an empty collection."""
    origin = get_origin(hint)
    if type(None) in get_args(hint):
        return None
    if origin is tuple:
        return ()
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {}
    raise KeyError(name)


def _value(hint: Any, data: Any) -> Any:  # noqa: PLR0911 - one return for each kind of type
    origin = get_origin(hint)
    if data is None or hint is Any or origin is Literal:
        return data
    if origin in (Union, types.UnionType):
        return _union([option for option in get_args(hint) if option is not type(None)], data)
    if origin is np.ndarray:
        return _array(data, np.dtype(get_args(get_args(hint)[1])[0]))
    if origin is tuple:
        options = get_args(hint)
        if len(options) == 2 and options[1] is Ellipsis:
            return tuple(_value(options[0], item) for item in data)
        return tuple(_value(option, item) for option, item in zip(options, data, strict=True))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        item = get_args(hint)[1]
        return {_key(name): _value(item, value) for name, value in data.items()}
    if hint is complex:
        return complex(*data)
    if is_dataclass(hint):
        nested: Any = hint
        return read_as(nested, data)
    return float(data) if hint is float else data


def _union(options: list[Any], data: Any) -> Any:
    """Return the value as the first type that it fits; objects are told apart by their `kind`."""
    option: Any
    for option in options:
        if isinstance(data, Mapping) and get_origin(option) is Mapping:
            return data
        if is_dataclass(option) != isinstance(data, Mapping):
            continue
        kind = get_type_hints(option).get("kind") if is_dataclass(option) else None
        discriminated = get_origin(kind) is Literal and "kind" in data
        if discriminated and data["kind"] not in get_args(kind):
            continue
        if (
            is_dataclass(option)
            and not discriminated
            and not all(
                field.name in data or field.default is not MISSING or field.default_factory is not MISSING
                for field in fields(option)
            )
        ):
            continue
        return _value(option, data)
    return data


def _key(name: str) -> Any:
    """Return a key as it was before JSON made a text of it: member numbers are numbers."""
    return int(name) if name.isdecimal() else name


def _array(data: Any, dtype: np.dtype[Any]) -> NDArray[Any]:
    if dtype.kind == "c":
        pairs = np.array(data, dtype=float)
        values = pairs[..., 0] + 1j * pairs[..., 1] if pairs.size else np.zeros(0, complex)
    else:
        # None is what JSON has for nan
        values = np.array(data, dtype=float).astype(dtype) if dtype.kind != "f" else np.array(data, float)
    values.setflags(write=False)
    return values

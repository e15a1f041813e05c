"""Any frozen dataclass to plain JSON values and named arrays, and back by its annotations."""

import math
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from modallab.store.base import StoredDataError

Json = Any  # a tree of dict, list, str, int, float, bool, None
Arrays = dict[str, NDArray[Any]]
T = TypeVar("T")

# Keys that no dataclass field can have mark what JSON has no form for.
_TYPE, _ARRAY, _PAIRS, _COMPLEX, _FLOAT = "$type", "$array", "$pairs", "$complex", "$float"


def to_plain(value: object) -> tuple[Json, Arrays]:
    """Return a value as JSON, and its arrays by the path at which each belongs."""
    arrays: Arrays = {}
    return _encode(value, "", arrays), arrays


def from_plain(cls: type[T], tree: Json, arrays: Mapping[str, NDArray[Any]]) -> T:
    """Return the value of type `cls` that `to_plain` took apart.

    Raises
    ------
    StoredDataError
        If the tree does not fit the type's annotations.
    """
    value: T = _decode(cls, tree, arrays, cls.__name__)
    return value


def _encode(value: Any, path: str, arrays: Arrays) -> Json:  # noqa: PLR0911 - one return for each kind of type
    if isinstance(value, Enum):
        return value.value
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else {_FLOAT: repr(float(value))}
    if isinstance(value, complex):
        return {_COMPLEX: [value.real, value.imag]}
    if isinstance(value, np.generic):
        return _encode(value.item(), path, arrays)
    if isinstance(value, np.ndarray):
        arrays[path] = value
        return {_ARRAY: path}
    if isinstance(value, Mapping):
        return _encode_mapping(value, path, arrays)
    if isinstance(value, (tuple, list, frozenset)):
        items = sorted(value) if isinstance(value, frozenset) else value
        return [_encode(item, f"{path}.{i}", arrays) for i, item in enumerate(items)]
    if is_dataclass(value):
        tree: dict[str, Json] = {_TYPE: type(value).__name__}
        for field in (field for field in fields(value) if field.init):
            name = f"{path}.{field.name}" if path else field.name
            tree[field.name] = _encode(getattr(value, field.name), name, arrays)
        return tree
    raise TypeError(f"{path or 'the value'} is a {type(value).__name__}, which is not stored")


def _encode_mapping(value: Mapping[Any, Any], path: str, arrays: Arrays) -> Json:
    if all(isinstance(key, str) for key in value):
        return {str(key): _encode(item, f"{path}.{key}", arrays) for key, item in value.items()}
    pairs = enumerate(value.items())
    return {_PAIRS: [[_encode(k, path, arrays), _encode(v, f"{path}.{i}", arrays)] for i, (k, v) in pairs]}


@cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls)


def _misfit(path: str, expected: object) -> StoredDataError:
    return StoredDataError(f"{path} is not of its type", field=path, allowed=str(expected))


def _decode(hint: Any, tree: Json, arrays: Mapping[str, NDArray[Any]], path: str) -> Any:  # noqa: PLR0911 - one return for each kind of type
    if isinstance(tree, dict) and len(tree) == 1:
        if _ARRAY in tree:
            return arrays[tree[_ARRAY]]
        if _COMPLEX in tree:
            return complex(*tree[_COMPLEX])
        if _FLOAT in tree:
            return float(tree[_FLOAT])
    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        return _decode_union(get_args(hint), tree, arrays, path)
    if origin is Literal:
        if tree in get_args(hint):
            return tree
    elif origin is not None:
        return _decode_container(origin, get_args(hint), tree, arrays, path)
    elif is_dataclass(hint):
        return _decode_dataclass(hint, tree, arrays, path)
    else:
        return _decode_scalar(hint, tree, path)
    raise _misfit(path, hint)


def _decode_union(options: tuple[Any, ...], tree: Json, arrays: Mapping[str, NDArray[Any]], path: str) -> Any:
    for option in options:
        try:
            return _decode(option, tree, arrays, path)
        except StoredDataError:
            continue
    raise _misfit(path, " | ".join(map(str, options)))


def _class_named(cls: type, name: object) -> type | None:
    """Return the class itself or the subclass of it that has this name; None if there is none."""
    if cls.__name__ == name:
        return cls
    subclasses: list[type] = type.__subclasses__(cls)
    for subclass in subclasses:
        if (known_class := _class_named(subclass, name)) is not None:
            return known_class
    return None


def _decode_dataclass(cls: Any, tree: Json, arrays: Mapping[str, NDArray[Any]], path: str) -> Any:
    stored_class = _class_named(cls, tree.get(_TYPE)) if isinstance(tree, dict) else None
    if stored_class is None:
        raise _misfit(path, cls.__name__)
    cls = stored_class
    hints = _hints(cls)
    names = {field.name for field in fields(cls) if field.init}
    if unknown := set(tree) - names - {_TYPE}:
        raise _misfit(f"{path}.{min(unknown)}", f"a field of {cls.__name__}")
    values = {name: _decode(hints[name], tree[name], arrays, f"{path}.{name}") for name in names & set(tree)}
    return cls(**values)


def _decode_container(
    origin: Any, options: tuple[Any, ...], tree: Json, arrays: Mapping[str, NDArray[Any]], path: str
) -> Any:
    if issubclass(origin, Mapping):
        if not isinstance(tree, dict):
            raise _misfit(path, origin)
        key, item = options
        entries = tree[_PAIRS] if _PAIRS in tree else tree.items()
        return {_decode(key, k, arrays, path): _decode(item, v, arrays, f"{path}.{k}") for k, v in entries}
    if not isinstance(tree, list):
        raise _misfit(path, origin)
    if origin is tuple and not (len(options) == 2 and options[1] is Ellipsis):
        if len(options) != len(tree):
            raise _misfit(path, options)
        pairs = zip(options, tree, strict=True)
        return tuple(_decode(o, v, arrays, f"{path}.{i}") for i, (o, v) in enumerate(pairs))
    return origin(_decode(options[0], v, arrays, f"{path}.{i}") for i, v in enumerate(tree))


def _decode_scalar(hint: Any, tree: Json, path: str) -> Any:
    if hint in (Any, object):
        return tree
    if hint is float and isinstance(tree, (int, float)) and not isinstance(tree, bool):
        return float(tree)
    if isinstance(hint, type) and issubclass(hint, Enum) and tree in {member.value for member in hint}:
        return hint(tree)
    if hint in (None, type(None)) and tree is None:
        return None
    if isinstance(hint, type) and type(tree) is hint:
        return tree
    raise _misfit(path, hint)

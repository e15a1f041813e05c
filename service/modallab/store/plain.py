"""Any frozen dataclass to plain JSON values and named arrays, and back by its annotations."""

import math
import types
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, partial
from typing import Any, Literal, Self, TypeVar, Union, cast, get_args, get_origin, get_type_hints

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
    try:
        decode: _Decoder = _decoder(cast(Any, cls))
        value: T = decode(tree, arrays)
    except _Misfit as misfit:
        path = f"{cls.__name__}{misfit.path}"
        raise StoredDataError(
            f"{path} is not of its type", field=path, allowed=str(misfit.expected)
        ) from None
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


class _Misfit(Exception):
    """Tells that a tree does not fit an annotation; each level puts its name before the path."""

    def __init__(self, expected: object) -> None:
        super().__init__(expected)
        self.expected, self.path = expected, ""

    def within(self, name: object) -> Self:
        """Return this, raised below `name`."""
        self.path = f".{name}{self.path}"
        return self


# Annotations are read once: what is stored has thousands of values of a dozen types.
_Decoder = Callable[[Json, Mapping[str, NDArray[Any]]], Any]


@cache
def _decoder(hint: Any) -> _Decoder:
    """Return the function that makes values of a type."""
    of_type = _decoder_by_kind(hint)

    def decode(tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
        if isinstance(tree, dict) and len(tree) == 1:
            if _ARRAY in tree:
                return arrays[tree[_ARRAY]]
            if _COMPLEX in tree:
                return complex(*tree[_COMPLEX])
            if _FLOAT in tree:
                return float(tree[_FLOAT])
        return of_type(tree, arrays)

    return decode


def _decoder_by_kind(hint: Any) -> _Decoder:
    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        return _union_decoder(get_args(hint))
    if origin is Literal:
        return _literal_decoder(hint)
    if origin is not None:
        return _container_decoder(origin, get_args(hint))
    return partial(_decode_dataclass if is_dataclass(hint) else _decode_scalar, hint)


def _union_decoder(options: tuple[Any, ...]) -> _Decoder:
    decoders = [_decoder(option) for option in options]
    expected = " | ".join(map(str, options))

    def decode(tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
        if tree is None and type(None) in options:
            return None
        for decoder in decoders:
            try:
                return decoder(tree, arrays)
            except _Misfit:
                continue
        raise _Misfit(expected)

    return decode


def _literal_decoder(hint: Any) -> _Decoder:
    def decode(tree: Json, _arrays: Mapping[str, NDArray[Any]]) -> Any:
        if tree in get_args(hint):
            return tree
        raise _Misfit(hint)

    return decode


def _class_named(cls: type, name: object) -> type | None:
    """Return the class itself or the subclass of it that has this name; None if there is none."""
    if cls.__name__ == name:
        return cls
    subclasses: list[type] = type.__subclasses__(cls)
    for subclass in subclasses:
        if (known_class := _class_named(subclass, name)) is not None:
            return known_class
    return None


@cache
def _field_decoders(cls: Any) -> dict[str, _Decoder]:
    hints = get_type_hints(cls)
    return {field.name: _decoder(hints[field.name]) for field in fields(cls) if field.init}


def _decode_dataclass(cls: Any, tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
    stored_class = _class_named(cls, tree.get(_TYPE)) if isinstance(tree, dict) else None
    if stored_class is None:
        raise _Misfit(cls.__name__)
    decoders = _field_decoders(stored_class)
    values = {}
    for name, value in tree.items():
        if name == _TYPE:
            continue
        if name not in decoders:
            raise _Misfit(f"a field of {stored_class.__name__}").within(name)
        values[name] = _decode_at(name, decoders[name], value, arrays)
    return stored_class(**values)


def _decode_at(name: object, decoder: _Decoder, tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
    try:
        return decoder(tree, arrays)
    except _Misfit as misfit:
        raise misfit.within(name) from None


def _container_decoder(origin: Any, options: tuple[Any, ...]) -> _Decoder:
    if issubclass(origin, Mapping):
        return _mapping_decoder(origin, *options)
    if origin is tuple and not (len(options) == 2 and options[1] is Ellipsis):
        return _tuple_decoder(options)
    if not issubclass(origin, (tuple, list, frozenset)):  # an array, which has a mark
        return partial(_refuse, origin)
    decoder = _decoder(options[0])

    def decode(tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
        if not isinstance(tree, list):
            raise _Misfit(origin)
        return origin(_decode_at(i, decoder, item, arrays) for i, item in enumerate(tree))

    return decode


def _mapping_decoder(origin: Any, key_hint: Any, item_hint: Any) -> _Decoder:
    key_decoder, item_decoder = _decoder(key_hint), _decoder(item_hint)

    def decode(tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
        if not isinstance(tree, dict):
            raise _Misfit(origin)
        entries = tree[_PAIRS] if _PAIRS in tree else tree.items()
        return {key_decoder(key, arrays): _decode_at(key, item_decoder, v, arrays) for key, v in entries}

    return decode


def _tuple_decoder(options: tuple[Any, ...]) -> _Decoder:
    decoders = [_decoder(option) for option in options]

    def decode(tree: Json, arrays: Mapping[str, NDArray[Any]]) -> Any:
        if not isinstance(tree, list) or len(tree) != len(decoders):
            raise _Misfit(options)
        pairs = zip(decoders, tree, strict=True)
        return tuple(_decode_at(i, decoder, item, arrays) for i, (decoder, item) in enumerate(pairs))

    return decode


def _refuse(expected: Any, _tree: Json, _arrays: Mapping[str, NDArray[Any]]) -> Any:
    raise _Misfit(expected)


def _decode_scalar(hint: Any, tree: Json, _arrays: Mapping[str, NDArray[Any]]) -> Any:
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
    raise _Misfit(hint)

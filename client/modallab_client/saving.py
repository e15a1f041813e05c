"""Results in files: numbers as arrays of an npz file, the rest as JSON in it."""

import io
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from modallab_client import correlation, estimates, models, results, time_records
from modallab_client._generated import models as generated

_DESCRIPTION = "description"  # the array that holds the JSON
_KIND, _ARRAY, _ITEMS, _PAIRS, _TUPLE, _COMPLEX = "kind", "array", "items", "pairs", "tuple", "complex"


def save(result: Any, path: str | Path) -> Path:
    """Write a result to a file, and return the file's path.

    Parameters
    ----------
    result
        Anything that the client returns: a measurement, modes, an update, a diagnosis, time records,
        estimates.
    path
        Mostly with the suffix `.npz`.

    Raises
    ------
    TypeError
        If it is no result of the client.
    """
    if type(result).__name__ not in _kinds() or not is_dataclass(result):
        raise TypeError(f"a result of the client can be saved, not {type(result).__name__}")
    arrays: dict[str, NDArray[Any]] = {}
    description = json.dumps(_written(result, arrays))
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{_DESCRIPTION: np.array(description)}, **arrays)
    target = Path(path)
    target.write_bytes(buffer.getvalue())
    return target


def load(path: str | Path) -> Any:
    """Return the result that `save` wrote to a file.

    Raises
    ------
    ValueError
        If the file has no result of this client.
    """
    try:
        content = io.BytesIO(Path(path).read_bytes())
        with np.load(content, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return _read(json.loads(str(arrays[_DESCRIPTION])), arrays)
    except (BadZipFile, EOFError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{Path(path).name} has no result of this client: {error}") from None


@cache
def _kinds() -> dict[str, type]:
    """Return the types of results by name."""
    modules = (generated, models, correlation, time_records, estimates, results)
    return {cls.__name__: cls for module in modules for cls in vars(module).values() if _is_kind(cls)}


def _is_kind(thing: Any) -> bool:
    return isinstance(thing, type) and is_dataclass(thing) and not thing.__name__.endswith("Methods")


def _written(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:  # noqa: PLR0911 - one return for each kind of value
    """Return a value as JSON; its arrays go to `arrays`."""
    if is_dataclass(value) and not isinstance(value, type):
        parts = {field.name: _written(getattr(value, field.name), arrays) for field in fields(value)}
        return {_KIND: type(value).__name__, _ITEMS: parts}
    if isinstance(value, np.ndarray):
        name = f"array_{len(arrays)}"
        arrays[name] = value
        return {_ARRAY: name}
    if isinstance(value, Mapping):
        pairs = [[_written(key, arrays), _written(item, arrays)] for key, item in value.items()]
        return {_PAIRS: pairs}
    if isinstance(value, (list, tuple)):
        items = [_written(item, arrays) for item in value]
        return {_TUPLE: items} if isinstance(value, tuple) else items
    if isinstance(value, complex):
        return {_COMPLEX: [value.real, value.imag]}
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, (str, int, float)):
        return value
    raise TypeError(f"{type(value).__name__} is no part of a result")


def _read(value: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:  # noqa: PLR0911 - as above
    """Return what `_written` made JSON of."""
    if isinstance(value, list):
        return [_read(item, arrays) for item in value]
    if not isinstance(value, dict):
        return value
    if _ARRAY in value:
        array = arrays[value[_ARRAY]]
        array.flags.writeable = False
        return array
    if _TUPLE in value:
        return tuple(_read(item, arrays) for item in value[_TUPLE])
    if _PAIRS in value:
        return {_read(key, arrays): _read(item, arrays) for key, item in value[_PAIRS]}
    if _COMPLEX in value:
        return complex(*value[_COMPLEX])
    kind: Any = _kinds()[value[_KIND]]
    known = {field.name for field in fields(kind)}
    parts = {name: _read(item, arrays) for name, item in value[_ITEMS].items() if name in known}
    return kind(**parts)

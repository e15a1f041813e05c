"""Specifications of arrays from the dataclasses that hold them: type, shape and meaning of their fields."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from modallab.api.arrays import SHAPE, ArraySpec, Item
from modallab.api.replies import attribute_docs

_ITEMS: Mapping[str, Item] = {"f": "real", "c": "complex", "i": "integer", "b": "flag"}


def arrays_of(domain: type, *names: str, **renamed: str) -> dict[str, ArraySpec]:
    """Return the specifications of fields that hold arrays, by their names in a reply.

    Parameters
    ----------
    domain
        A dataclass whose attribute docstrings have shapes such as `(n_freq, n_out)`, of one axis or more.
    names
        Fields that a reply calls by the same name.
    renamed
        Other fields, as `name_in_the_reply="field"`.
    """
    hints, docs = get_type_hints(domain), attribute_docs(domain)
    required = {field.name for field in fields(domain) if field.default is MISSING}
    specs = {}
    for name, field in ({name: name for name in names} | renamed).items():
        options = set(get_args(hints[field])) if NoneType in get_args(hints[field]) else {hints[field]}
        (hint,) = options - {NoneType}
        shapes = SHAPE.findall(docs[field])
        if not shapes and get_origin(hint) is tuple:
            shapes = [f"n_{field}"]
        optional = NoneType in options or field not in required
        specs[name] = ArraySpec(docs[field], " | ".join(shapes), _item(hint), optional)
    return specs


def _item(hint: Any) -> Item:
    """Return the type of an entry of an array, of a number, or of a tuple of degrees of freedom."""
    if get_origin(hint) is tuple:
        return "text"
    scalar = get_args(get_args(hint)[1])[0] if get_origin(hint) is np.ndarray else hint
    return _ITEMS[np.dtype(scalar).kind]

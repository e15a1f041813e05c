"""Replies that carry arrays: NumPy's archive (npz), or JSON for those who ask for it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import Depends, Query, Request
from numpy.typing import NDArray
from starlette.responses import JSONResponse, Response

from modallab.api.limits import REPLY
from modallab.api.media import JSON_TYPE, accepts
from modallab.api.thinning import numbers
from modallab.core.errors import InvalidInputError
from modallab.store.npz import pack, unpack

Arrays = Mapping[str, NDArray[Any]]
Item = Literal["real", "complex", "integer", "text", "flag"]

SHAPE = re.compile(r"\((n\w*(?:, \w+)*),?\)")  # in a docstring
MEDIA_TYPE = "application/octet-stream"
_SINGLE = {"c": np.complex64, "f": np.float32}
_ITEMS: Mapping[Item, dict[str, Any]] = {
    "real": {"type": ["number", "null"]},
    "complex": {
        "type": "array",
        "items": {"type": ["number", "null"]},
        "minItems": 2,
        "maxItems": 2,
        "description": "[real part, imaginary part]",
    },
    "integer": {"type": "integer"},
    "text": {"type": "string"},
    "flag": {"type": "boolean"},
}


@dataclass(frozen=True)
class ArraySpec:
    """One array of a reply.

    Parameters
    ----------
    doc
        Unit, then meaning; the shape may be in it.
    shape
        Names of the axes, such as `n_lines, n_out`; `|` separates shapes that it may have.
    item
        Type of an entry.
    optional
        True where some replies leave the array out.
    """

    doc: str
    shape: str
    item: Item = "real"
    optional: bool = False

    def schema(self) -> dict[str, Any]:
        """Return the JSON schema of the nested lists."""
        shapes = [_nested(self.item, shape.strip()) for shape in self.shape.split("|")]
        has_shape = not self.shape or SHAPE.search(self.doc)
        described = {"description": self.doc if has_shape else f"({self.shape}) {self.doc}"}
        return described | (shapes[0] if len(shapes) == 1 else {"anyOf": shapes})


def _nested(item: Item, shape: str) -> dict[str, Any]:
    schema = dict(_ITEMS[item])
    for _ in filter(None, shape.split(",")):
        schema = {"type": "array", "items": schema}
    return schema


@dataclass(frozen=True)
class ArraysFormat:
    """The form in which a caller wants arrays."""

    as_json: bool
    precision: Literal["double", "single"]

    def reply(self, arrays: Arrays) -> Response:
        """Return arrays as a reply; `InvalidInputError` if they are too many for JSON."""
        return _json(arrays) if self.as_json else self._npz(arrays)

    def reply_npz(self, payload: bytes) -> Response:
        """Return an npz file as a reply, repacked only where another form was asked for."""
        if self.as_json:
            return _json(unpack(payload))
        return self._npz(unpack(payload)) if self.precision == "single" else _bytes(payload)

    def _npz(self, arrays: Arrays) -> Response:
        single = self.precision == "single"
        return _bytes(pack({name: _shortened(a) if single else a for name, a in arrays.items()}))


async def _arrays_format(
    request: Request,
    precision: Annotated[
        Literal["double", "single"],
        Query(description="`single` halves the size of an npz reply: complex64 and float32"),
    ] = "double",
) -> ArraysFormat:
    return ArraysFormat(accepts(request.headers, JSON_TYPE, MEDIA_TYPE), precision)


ArraysFormatDep = Annotated[ArraysFormat, Depends(_arrays_format)]


def array_replies(name: str, doc: str, specs: Mapping[str, ArraySpec]) -> dict[int | str, dict[str, Any]]:
    """Return the `responses` of a route that replies with arrays.

    Parameters
    ----------
    name
        Of the schema's component.
    doc
        Subject of the arrays.
    specs
        Arrays by name; a reply may have more, which are of the same kinds.
    """
    schema = {
        "title": name,
        "x-component": name,
        "type": "object",
        "description": doc,
        "properties": {key: spec.schema() for key, spec in specs.items()},
        "required": [key for key, spec in specs.items() if not spec.optional],
        "additionalProperties": True,
    }
    content = {
        MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}},
        JSON_TYPE: {"schema": schema},
    }
    description = f"{doc}: an uncompressed npz file, or JSON where `Accept` asks for it"
    return {200: {"description": description, "content": content}}


def _bytes(payload: bytes) -> Response:
    return Response(payload, media_type=MEDIA_TYPE, headers={"Vary": "Accept"})


def _json(arrays: Arrays) -> Response:
    size = sum(array.size * (2 if array.dtype.kind == "c" else 1) for array in arrays.values())
    if size > REPLY.json_array_values:
        raise InvalidInputError(
            "these arrays are too large for JSON: take them as npz",
            field="Accept",
            value=JSON_TYPE,
            allowed=MEDIA_TYPE,
        )
    body = {name: numbers(array) for name, array in arrays.items()}
    return JSONResponse(body, headers={"Vary": "Accept"})


def _shortened(array: NDArray[Any]) -> NDArray[Any]:
    # The axis keeps its digits: neighbouring lines of a long record differ in the seventh.
    return (
        array
        if array.dtype.kind not in _SINGLE or array.ndim < 2
        else array.astype(_SINGLE[array.dtype.kind])
    )

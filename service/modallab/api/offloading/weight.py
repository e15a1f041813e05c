"""Weight of a request: the bytes of what is stored of the things that it names, and of its body."""

import json
import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from anyio import to_thread
from starlette.requests import Request

from modallab.api.offloading.settings import OFFLOADING
from modallab.store.base import Store

_FORM = "multipart/form-data"
_OTHERS = ("id", "other")  # names of ids that do not end in `_id`


def is_form(request: Request) -> bool:
    """Return whether a request brings files."""
    return request.headers.get("content-type", "").startswith(_FORM)


async def weight_of(request: Request, store: Store) -> float:
    """Return the weight of a request, bytes; infinity with files, which are read in a process anyway."""
    announced = request.headers.get("content-length", "0")
    if is_form(request) or not announced.isdecimal() or int(announced) > OFFLOADING.light:
        return math.inf
    if "chunked" in request.headers.get("transfer-encoding", ""):
        return math.inf
    body: Any = None
    with suppress(ValueError):  # what is no JSON is refused where it is read
        body = json.loads(await request.body() or "null")
    fields = body if isinstance(body, dict) else {}
    ids = {*_ids(request.path_params), *_ids(request.query_params), *_ids(fields)}
    stored = await to_thread.run_sync(store.weight, sorted(ids), OFFLOADING.array_bytes) if ids else 0
    return int(announced) + OFFLOADING.element_bytes * _n_elements(fields) + stored


def _ids(values: Any) -> Iterator[str]:
    for name, value in values.items():
        if (name in _OTHERS or name.endswith("_id")) and isinstance(value, str):
            yield value


def _n_elements(fields: dict[str, Any]) -> int:
    """Return the number of elements that a body asks for by number; 0 where it does not."""
    counts = fields.get("n_elements", 0)
    counts = counts if isinstance(counts, list) else [counts]
    return math.prod(n for n in counts if isinstance(n, int)) if counts else 0

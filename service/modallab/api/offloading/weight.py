"""Weight of a request: the bytes of what is stored of the things that it names, and of its body."""

import json
import math
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any

from anyio import to_thread
from starlette.requests import Request

from modallab.api.offloading.settings import OFFLOADING
from modallab.api.wire import ID_PATTERN
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
    described = int(announced) + OFFLOADING.element_bytes * _n_elements(fields)
    if not ids or _is_stored_file(request):
        return described
    # What is stored of a thing is told without a look at what it was made from.
    origins = not request.url.path.endswith(str(request.path_params.get("id", "/")))
    weigh = partial(store.weight, sorted(ids), OFFLOADING.array_bytes, origins=origins)
    return described + await to_thread.run_sync(weigh)


def _is_stored_file(request: Request) -> bool:
    """Return whether arrays are asked for as they lie in the store."""
    wants_json = "json" in request.headers.get("accept", "")
    path = f"/{request.path_params.get('id')}/arrays"
    return request.url.path.endswith(path) and not request.url.query and not wants_json


def _ids(values: Any) -> Iterator[str]:
    for name, value in values.items():
        named = name in _OTHERS or name.endswith("_id")
        # What is no id is refused where it is read; a database may not even compare it.
        if named and isinstance(value, str) and re.fullmatch(ID_PATTERN, value):
            yield value


def _n_elements(fields: dict[str, Any]) -> int:
    """Return the number of elements that a body asks for by number; 0 where it does not."""
    counts = fields.get("n_elements", 0)
    counts = counts if isinstance(counts, list) else [counts]
    return math.prod(n for n in counts if isinstance(n, int)) if counts else 0

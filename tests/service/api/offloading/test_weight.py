import asyncio
import json
from typing import Any

from starlette.requests import Request

from modallab.api.offloading.weight import weight_of

SPOILT = "\xa1\x00;"  # PostgreSQL has no text with a NUL


class WeighedStore:
    """Keeps the ids whose weights are asked for."""

    def __init__(self) -> None:
        self.ids: list[str] = []

    def weight(self, ids: list[str], _array_bytes: float, *, origins: bool) -> float:
        self.ids += ids
        return 0.0


def request_of(query: bytes, body: Any) -> Request:
    sent = json.dumps(body).encode()

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": sent, "more_body": False}

    scope = {
        "type": "http",
        "method": "POST",
        "path": "/v1/rigs/R1/checks",
        "path_params": {"id": "R1"},
        "query_string": query,
        "headers": [(b"content-length", str(len(sent)).encode())],
    }
    return Request(scope, receive)


def test_only_what_can_be_an_id_is_looked_up() -> None:
    store = WeighedStore()
    spoilt = request_of(b"structure_id=%C2%A1%00%3B", {"other": SPOILT, "rig_id": "\ud800"})
    asyncio.run(weight_of(spoilt, store))  # type: ignore[arg-type]
    assert store.ids == ["R1"]


def test_what_path_query_and_body_name_is_looked_up() -> None:
    store = WeighedStore()
    asyncio.run(weight_of(request_of(b"structure_id=S1", {"other": "M1"}), store))  # type: ignore[arg-type]
    assert store.ids == ["M1", "R1", "S1"]

"""Content types: the one that a caller prefers, and tables as CSV."""

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Annotated, Any

from fastapi import Depends, Request
from starlette.datastructures import Headers
from starlette.responses import Response

JSON_TYPE = "application/json"
CSV_TYPE = "text/csv"


def accepts(headers: Headers, media_type: str, default: str) -> bool:
    """Return whether a caller names a content type and prefers it to the default one.

    RFC 9110, 12.5.1. A wildcard does not count: a caller that accepts any type receives the default.
    """
    quality = dict(_quality(entry) for entry in headers.get("accept", "").split(",") if entry.strip())
    return quality.get(media_type, 0.0) > max(quality.get(default, 0.0), 0.0)


def _quality(entry: str) -> tuple[str, float]:
    media_type, *parameters = (part.strip() for part in entry.split(";"))
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name == "q":
            try:
                return media_type.lower(), float(value)
            except ValueError:
                return media_type.lower(), 0.0
    return media_type.lower(), 1.0


async def _wants_csv(request: Request) -> bool:
    return accepts(request.headers, CSV_TYPE, JSON_TYPE)


CsvWanted = Annotated[bool, Depends(_wants_csv)]


def csv_replies(columns: Sequence[str]) -> dict[int | str, dict[str, Any]]:
    """Return the `responses` of a route that replies with a table where `Accept` asks for CSV."""
    text = "columns " + ", ".join(f"`{name}`" for name in columns)
    schema = {"type": "string", "description": text}
    return {200: {"description": "JSON, or a table as CSV", "content": {CSV_TYPE: {"schema": schema}}}}


def csv_reply(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> Response:
    """Return a table as a CSV reply (RFC 4180); an entry that is None is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    return Response(text.getvalue(), media_type=CSV_TYPE, headers={"Vary": "Accept"})


def csv_or(
    reply: Callable[[], Any], columns: Sequence[str], rows: Iterable[Mapping[str, Any]], *, as_csv: bool
) -> Any:
    """Return rows as a CSV reply if that is wanted, or else what a function makes of them."""
    return csv_reply(columns, rows) if as_csv else reply()

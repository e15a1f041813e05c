"""Files out and in: replies that a browser keeps, where their content is from, forms beside JSON."""

from datetime import datetime
from typing import Any

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.routing import Match
from starlette.types import Scope

from modallab.api.media import CSV_TYPE
from modallab.api.offloading.route import OffloadedRoute
from modallab.interchange.uff_text import Origin
from modallab.store.base import Entry

_BYTES = "application/octet-stream"
_HDF5 = _BYTES
_TEXT = "text/plain"
WAV_TYPE = "audio/wav"
ZIP_TYPE = _BYTES  # generators of clients know no type of a zip


def _answers(description: str, media_type: str, schema: dict[str, str]) -> dict[int | str, dict[str, Any]]:
    return {200: {"description": description, "content": {media_type: {"schema": schema}}}}


# For the `responses` of routes that answer with files.
UFF = _answers("Universal file", _BYTES, {"type": "string", "format": "binary"})
HDF5 = _answers("HDF5 file", _HDF5, {"type": "string", "format": "binary"})
ZIP = _answers("Project file", ZIP_TYPE, {"type": "string", "format": "binary"})
FRF_TEXT = _answers("The thesis program's text file", _TEXT, {"type": "string"})
# For the `openapi_extra` of a route that takes a file instead of JSON.
FILE = {
    "requestBody": {
        "content": {
            "multipart/form-data": {
                "schema": {
                    "type": "object",
                    "required": ["file"],
                    "additionalProperties": False,
                    "properties": {
                        "file": {
                            "type": "string",
                            "format": "binary",
                            "description": "universal file, dataset 55",
                        }
                    },
                }
            }
        }
    }
}


def uff_reply(payload: bytes, name: str) -> Response:
    """Return a universal file as a reply that browsers keep under this name."""
    return _reply(payload, f"{name}.uff", _BYTES)


def hdf5_reply(payload: bytes, name: str) -> Response:
    """Return an HDF5 file as a reply that browsers keep under this name."""
    return _reply(payload, f"{name}.h5", _HDF5)


def frf_text_reply(payload: bytes, name: str) -> Response:
    """Return a `.FRF` file as a reply that browsers keep under this name."""
    return _reply(payload, f"{name}.frf", _TEXT)


def wav_reply(payload: bytes, name: str) -> Response:
    """Return a sound file as a reply that browsers keep under this name."""
    return _reply(payload, f"{name}.wav", WAV_TYPE)


def _reply(payload: bytes, name: str, media_type: str) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(payload, media_type=media_type, headers=headers)


def origin(entry: Entry, content: str) -> Origin:
    """Return where a stored thing is from, for the header of its file."""
    return Origin(entry.id, content, entry.version, datetime.fromisoformat(entry.created))


class FormRoute(OffloadedRoute):
    """Takes forms only, so that the same path may take JSON in another route, declared after it."""

    media_type = "multipart/form-data"

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether the request is for this route."""
        if not Headers(scope=scope).get("content-type", "").startswith(self.media_type):
            return Match.NONE, {}
        return super().matches(scope)


class CsvRoute(FormRoute):
    """Takes tables as CSV only."""

    media_type = CSV_TYPE

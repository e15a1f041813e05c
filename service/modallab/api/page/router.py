"""The page in the browser, and the reference of the API: files of this computer, no other host."""

import gzip
import mimetypes
from functools import cache
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Header, HTTPException
from starlette.responses import Response
from swagger_ui_bundle import swagger_ui_path

STATIC = Path(__file__).parent / "static"
SWAGGER = ("swagger-ui-bundle.js", "swagger-ui.css")  # what the reference needs of Swagger UI

_COMMON = "default-src 'none'; script-src 'self'; connect-src 'self'; font-src 'self'; base-uri 'none'; "
_CLOSED = "form-action 'none'; frame-ancestors 'none'"
PAGE_POLICY = f"{_COMMON}style-src 'self'; img-src 'self' data: blob:; {_CLOSED}"
# The reference sets styles in its elements, and its icons are data.
REFERENCE_POLICY = f"{_COMMON}style-src 'self' 'unsafe-inline'; img-src 'self' data:; {_CLOSED}"

_FOREVER = "public, max-age=31536000, immutable"  # the names of built files change with their content
_ALWAYS_ASK = "no-cache"
_COMPRESSED = frozenset({".woff2", ".png"})  # already

router = APIRouter(include_in_schema=False)
Encodings = Annotated[str, Header()]


@router.get("/", name="page")
async def get_page(accept_encoding: Encodings = "") -> Response:
    """Return the page."""
    return _file("index.html", accept_encoding, PAGE_POLICY)


@router.get("/docs", name="reference")
async def get_reference(accept_encoding: Encodings = "") -> Response:
    """Return the reference of the API, which reads `/openapi.json`."""
    return _file("docs/index.html", accept_encoding, REFERENCE_POLICY)


@router.get("/icon.svg", name="page_icon")
async def get_icon(accept_encoding: Encodings = "") -> Response:
    """Return the icon of the page."""
    return _file("icon.svg", accept_encoding, PAGE_POLICY)


@router.get("/assets/{name}", name="page_asset")
async def get_asset(name: str, accept_encoding: Encodings = "") -> Response:
    """Return a script, a style sheet or a font of the page."""
    return _file(f"assets/{name}", accept_encoding, PAGE_POLICY, keep=_FOREVER)


@router.get("/docs/{name}", name="reference_asset")
async def get_reference_asset(name: str, accept_encoding: Encodings = "") -> Response:
    """Return a script or a style sheet of the reference."""
    return _file(f"docs/{name}", accept_encoding, REFERENCE_POLICY)


def _file(path: str, accepted: str, policy: str, keep: str = _ALWAYS_ASK) -> Response:
    """Return a file of the package; 404 where there is none of that name."""
    zipped = "gzip" in accepted
    content = _content(path, zipped=zipped)
    if content is None:
        raise HTTPException(404, "the page has no such file")
    headers = {
        "Cache-Control": keep,
        "Content-Security-Policy": policy,
        "Referrer-Policy": "no-referrer",
        "Vary": "Accept-Encoding",
        "X-Content-Type-Options": "nosniff",
    }
    if zipped and Path(path).suffix not in _COMPRESSED:
        headers["Content-Encoding"] = "gzip"
    return Response(content, media_type=_media_type(path), headers=headers)


@cache
def _files() -> dict[str, Path]:
    """Return the files there are: a name of a request is looked up here, and never opened."""
    own = {path.relative_to(STATIC).as_posix(): path for path in STATIC.rglob("*") if path.is_file()}
    return own | {f"docs/{name}": Path(swagger_ui_path / name) for name in SWAGGER}


@cache
def _content(path: str, *, zipped: bool) -> bytes | None:
    file = _files().get(path)
    if file is None:
        return None
    content = file.read_bytes()
    return gzip.compress(content, mtime=0) if zipped and Path(path).suffix not in _COMPRESSED else content


def _media_type(path: str) -> str:
    # Not of the operating system's tables: some have no type of fonts, or another of scripts.
    known = {".js": "text/javascript", ".woff2": "font/woff2", ".svg": "image/svg+xml"}
    suffix = Path(path).suffix
    return known.get(suffix) or mimetypes.guess_type(path)[0] or "application/octet-stream"

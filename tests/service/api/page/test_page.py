"""The page and the reference of the API come from this package, and from no other host."""

import gzip
import re
from pathlib import Path
from typing import Any

import pytest
from swagger_ui_bundle import swagger_ui_path

from modallab.api.page.router import STATIC

FOREIGN = re.compile(r"""(?:src|href)=["'](?:https?:)?//""")
FIRST_LOAD = 115_000  # bytes of the files; replies of the API add some 27 kB, and all shall be below 150 kB


def assets(html: str) -> list[str]:
    """Return the addresses of the files that a document names."""
    return re.findall(r'(?:src|href)="\./([^"]+)"', html)


def test_the_page_is_at_the_root_with_a_strict_policy(service: Any) -> None:
    reply = service.request("GET", "/")
    assert reply.status_code == 200
    assert reply.headers["content-type"].startswith("text/html")
    policy = reply.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert not FOREIGN.search(reply.text)
    assert "<script>" not in reply.text
    assert " style=" not in reply.text


def test_every_file_that_the_page_names_is_there(service: Any) -> None:
    names = assets(service.request("GET", "/").text)
    assert {Path(name).suffix for name in names} == {".js", ".css", ".svg"}
    for name in names:
        reply = service.request("GET", f"/{name}")
        assert reply.status_code == 200, name
        assert reply.headers["x-content-type-options"] == "nosniff"
        if name.startswith("assets/"):
            assert "immutable" in reply.headers["cache-control"]


def test_the_first_load_is_small(service: Any) -> None:
    zipped = {"Accept-Encoding": "gzip"}
    html = service.request("GET", "/").text
    style = next(name for name in assets(html) if name.endswith(".css"))
    fonts = re.findall(r"url\(\./([^)]+woff2)\)", service.request("GET", f"/{style}").text)
    assert len(fonts) == 2
    names = ["", *assets(html), *(f"assets/{font}" for font in fonts)]
    replies = [service.request("GET", f"/{name}", headers=zipped) for name in names]
    # httpx unpacks what it is sent: the length of the transfer is in the header.
    assert sum(int(reply.headers["content-length"]) for reply in replies) < FIRST_LOAD


def test_text_is_sent_packed_and_says_so(service: Any) -> None:
    script = next(name for name in assets(service.request("GET", "/").text) if name.endswith(".js"))
    plain = service.request("GET", f"/{script}", headers={"Accept-Encoding": "identity"})
    packed = service.request("GET", f"/{script}", headers={"Accept-Encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"] == "Accept-Encoding"
    assert int(packed.headers["content-length"]) == len(gzip.compress(plain.content, mtime=0))
    assert packed.content == plain.content


def test_the_reference_of_the_api_needs_no_other_host(service: Any) -> None:
    reply = service.request("GET", "/docs")
    assert reply.status_code == 200
    assert not FOREIGN.search(reply.text)
    assert "script-src 'self';" in reply.headers["content-security-policy"]
    for name in assets(reply.text):
        assert service.request("GET", f"/{name}").status_code == 200, name
    assert 'url: "./openapi.json"' in service.request("GET", "/docs/start.js").text
    assert service.get("/openapi.json")["info"]["title"] == "modallab"


def test_the_reference_s_program_is_that_of_its_package_and_no_copy(service: Any) -> None:
    for name, kind in (("swagger-ui-bundle.js", "text/javascript"), ("swagger-ui.css", "text/css")):
        reply = service.request("GET", f"/docs/{name}")
        assert reply.headers["content-type"].startswith(kind)
        assert reply.content == Path(swagger_ui_path / name).read_bytes()
        assert not (STATIC / "docs" / name).exists()
    assert service.request("GET", "/docs/swagger-ui-bundle.js.map").status_code == 404


@pytest.mark.parametrize(
    "path",
    ["/assets/none.js", "/assets/..%2findex.html", "/docs/%2e%2e%2findex.html", "/assets/sources.sha256"],
)
def test_there_is_nothing_but_the_files_of_the_page(service: Any, path: str) -> None:
    reply = service.request("GET", path)
    assert reply.status_code == 404
    assert reply.headers["content-type"] == "application/problem+json"


def test_the_page_is_no_part_of_the_api(service: Any) -> None:
    paths = service.get("/openapi.json")["paths"]
    assert all(path.startswith("/v1/") for path in paths)

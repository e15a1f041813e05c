"""The documentation as a site: it builds strictly, all links lead somewhere, nothing comes from elsewhere."""

import json
import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from docs.reference.operations import pages

ROOT = Path(__file__).parents[2]
DOCUMENT = json.loads((ROOT / "docs" / "openapi.json").read_text(encoding="utf-8"))


class Links(HTMLParser):
    """What a page loads, where its links lead, and the anchors that it has."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if given.get("id"):
            self.anchors.add(str(given["id"]))
        if tag == "a" and given.get("href"):
            self.links.append(str(given["href"]))
        self.loaded += [str(given[name]) for name in ("src", "href") if tag != "a" and given.get(name)]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, Links]:
    """The pages of the site by their file, as `make site` builds them."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    read = {}
    for path in folder.rglob("*.html"):
        read[path] = Links()
        read[path].feed(path.read_text(encoding="utf-8"))
    return read


def test_every_link_leads_to_a_file_and_an_anchor(site: dict[Path, Links]) -> None:
    assert len(site) > 80  # guides, effects, methods, requests
    for path, page in site.items():
        if path.name == "404.html":  # its links are those of the server's root
            continue
        for link in [*page.links, *page.loaded]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            assert target.is_file(), (path.name, link)
            if parts.fragment and target in site and not parts.fragment.startswith("__"):
                assert unquote(parts.fragment) in site[target].anchors, (path.name, link)


def test_no_page_loads_anything_from_another_host(site: dict[Path, Links]) -> None:
    loaded = {link for page in site.values() for link in page.loaded}
    assert any(link.endswith(".css") for link in loaded)
    assert not [link for link in loaded if urlsplit(link).netloc]


def test_the_client_and_the_requests_are_described(site: dict[Path, Links]) -> None:
    by_name = {"/".join(path.parts[-2:]): page for path, page in site.items()}
    client = next(page for path, page in site.items() if path.name == "client-reference.html")
    for name in ("Measurements.start", "ModalModels.start", "Diagnoses.start"):
        assert any(anchor.endswith(name) for anchor in client.anchors), name
    for methods in DOCUMENT["paths"].values():
        for operation in methods.values():
            page = by_name[f"api/{operation['tags'][0]}.html"]
            assert operation["operationId"] in page.anchors


def test_each_schema_has_its_fields_on_the_page() -> None:
    text = pages(DOCUMENT)["schemas.md"]
    for name, schema in DOCUMENT["components"]["schemas"].items():
        section = text.partition(f"## {name} {{")[2].partition("\n## ")[0]
        assert section, name
        for field in schema.get("properties", {}):
            assert f"| `{field}`" in section, (name, field)

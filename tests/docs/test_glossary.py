"""The glossary explains every name of the OpenAPI document, and names nothing that the document lacks."""

import importlib
import inspect
import json
import pkgutil
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import modallab_client

ROOT = Path(__file__).parents[2]
GLOSSARY = ROOT / "docs" / "glossary.md"
COLUMNS = ["term", "symbol, unit", "meaning", "API names"]
PLAIN_ENGLISH = frozenset(
    {"id", "name", "title", "type", "kind", "note", "notes", "created", "version", "message", "items"}
    | {"next", "limit", "number", "all"}
)


def _mappings(node: Any) -> Iterator[dict[str, Any]]:
    if isinstance(node, dict):
        yield node
        for value in node.values():
            yield from _mappings(value)
    elif isinstance(node, list):
        for value in node:
            yield from _mappings(value)


@cache
def _document() -> dict[str, Any]:
    document: dict[str, Any] = json.loads((ROOT / "docs" / "openapi.json").read_text())
    return document


@cache
def document_names() -> frozenset[str]:
    """Return property names, parameter names and enum values of the document."""
    names: set[str] = set()
    for mapping in _mappings(_document()):
        properties, values = mapping.get("properties"), mapping.get("enum")
        if isinstance(properties, dict):
            names.update(properties)
        if isinstance(values, list):
            names.update(value for value in values if isinstance(value, str))
        if isinstance(mapping.get("const"), str):
            names.add(mapping["const"])
        if "in" in mapping and "schema" in mapping:
            names.add(mapping["name"])
    return frozenset(names)


@cache
def path_names() -> frozenset[str]:
    """Return the segments of the document's paths without parameters."""
    return frozenset(segment for path in _document()["paths"] for segment in path.split("/") if segment)


@cache
def client_names() -> frozenset[str]:
    """Return public attributes of the client's classes."""
    names: set[str] = set()
    for module in pkgutil.iter_modules(modallab_client.__path__):
        if not module.name.startswith("_"):
            members = vars(importlib.import_module(f"modallab_client.{module.name}"))
            for cls in filter(inspect.isclass, members.values()):
                names.update(vars(cls), inspect.get_annotations(cls))
    return frozenset(name for name in names if not name.startswith("_"))


def cells(row: str) -> list[str]:
    """Return the cells of a table row."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip())[1:-1]]


@cache
def glossary_rows() -> tuple[tuple[str, ...], ...]:
    """Return the rows of all tables: term, symbol and unit, meaning, API names."""
    rows = [cells(line) for line in GLOSSARY.read_text().splitlines() if line.startswith("|")]
    return tuple(tuple(row) for row in rows if row != COLUMNS and not row[0].startswith("---"))


@cache
def glossary_names() -> frozenset[str]:
    """Return the names in the last column."""
    return frozenset(name for row in glossary_rows() for name in re.findall(r"`([^`]+)`", row[-1]))


def test_every_name_of_the_api_is_in_the_glossary_or_plain_english() -> None:
    missing = sorted(document_names() - glossary_names() - PLAIN_ENGLISH)
    assert not missing, (
        f"{len(missing)} names of docs/openapi.json are not explained. Add each in backticks to the last "
        f"column of the row in docs/glossary.md whose term it stands for (or add a row): {', '.join(missing)}"
    )


def test_every_api_name_of_the_glossary_exists() -> None:
    unknown = sorted(glossary_names() - document_names() - path_names() - client_names())
    assert not unknown, (
        "names in the last column of docs/glossary.md that docs/openapi.json does not have (renamed or "
        f"removed? change the row): {', '.join(unknown)}"
    )


def test_plain_english_names_are_used_and_not_explained_twice() -> None:
    assert document_names() >= PLAIN_ENGLISH, "remove these names from PLAIN_ENGLISH"
    assert not PLAIN_ENGLISH & glossary_names()


@pytest.mark.parametrize("row", glossary_rows(), ids=lambda row: row[0])
def test_row_has_a_term_and_a_meaning(row: tuple[str, ...]) -> None:
    assert len(row) == len(COLUMNS), "four cells; write a bar inside a cell as \\|"
    term, _, meaning, names = row
    assert term
    assert meaning.endswith(".")
    assert re.fullmatch(r"(`[^`]+`(, `[^`]+`)*)?", names)  # no name: a term of the guides


@pytest.mark.parametrize("guide", sorted(GLOSSARY.parent.glob("*.md")), ids=lambda path: path.stem)
def test_first_lines_of_each_guide_link_the_glossary(guide: Path) -> None:
    if guide != GLOSSARY:
        assert "](glossary.md)" in "".join(guide.read_text().splitlines(keepends=True)[:6])


def test_readme_links_the_glossary() -> None:
    assert "](docs/glossary.md)" in (ROOT / "README.md").read_text()

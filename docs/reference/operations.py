"""Pages of the API reference: one for the requests of each kind of object, from the OpenAPI document."""

import json
from collections.abc import Iterator
from typing import Any

from docs.reference.schemas import ANCHORS, cell, fields_table, type_of

Document = dict[str, Any]


def pages(document: Document) -> dict[str, str]:
    """Return the pages by file name: one for each tag, the schemas, and a list of all requests."""
    written = {f"{tag['name']}.md": tag_page(tag, document) for tag in document["tags"]}
    written["schemas.md"] = schemas_page(document)
    written["README.md"] = index(document)
    return written


def operations(document: Document, tag: str) -> Iterator[tuple[str, str, Document]]:
    """Yield path, method and description of each request with a tag."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            if tag in operation.get("tags", ()):
                yield path, method.upper(), operation


def index(document: Document) -> str:
    """Return the page that lists all requests."""
    parts = ["# Requests of the API", document["info"]["description"]]
    for tag in document["tags"]:
        name = tag["name"]
        rows = [
            f"| [`{method} {path}`]({name}.md#{operation['operationId']}) | {cell(summary(operation))} |"
            for path, method, operation in operations(document, name)
        ]
        table = "\n".join(["| request | |", "|---|---|", *rows])
        parts.append(f"## {name.replace('_', ' ')}\n\n{tag['description']}\n\n{table}")
    parts.append("All bodies and replies: [schemas](schemas.md).")
    return "\n\n".join(parts) + "\n"


def summary(operation: Document) -> str:
    """Return the first sentence of what a request does."""
    return str(operation.get("description") or operation["summary"]).split("\n")[0]


def tag_page(tag: Document, document: Document) -> str:
    """Return the page of the requests with a tag."""
    parts = [f"# {tag['name'].replace('_', ' ')}", tag["description"]]
    parts += [section(path, method, one) for path, method, one in operations(document, tag["name"])]
    return "\n\n".join(parts) + "\n"


def section(path: str, method: str, operation: Document) -> str:
    """Return what a request takes and returns."""
    parts = [f"## `{method} {path}` {{ #{operation['operationId']} }}"]
    parts.append(str(operation.get("description") or operation["summary"]))
    parameters = operation.get("parameters", ())
    if parameters:
        rows = [
            f"| `{one['name']}` | {one['in']} | {type_of(one['schema'])} "
            f"| {cell(one.get('description', ''))} |"
            for one in parameters
        ]
        parts.append("\n".join(["| parameter | in | type | meaning |", "|---|---|---|---|", *rows]))
    if "requestBody" in operation:
        for kind, content in operation["requestBody"]["content"].items():
            parts.append(f"Body, `{kind}`: {type_of(content['schema'])}.")
            parts += [
                f"```json\n{json.dumps(example['value'], indent=2)}\n```"
                for example in content.get("examples", {}).values()
            ]
    rows = [
        f"| {status} | {cell(reply['description'])} | {_contents(reply)} |"
        for status, reply in operation["responses"].items()
    ]
    parts.append("\n".join(["| status | | content |", "|---|---|---|", *rows]))
    return "\n\n".join(parts)


def _contents(reply: Document) -> str:
    return "<br>".join(
        f"`{kind}` {type_of(content['schema']) if content.get('schema') else ''}".strip()
        for kind, content in reply.get("content", {}).items()
    )


def schemas_page(document: Document) -> str:
    """Return the page of all bodies and replies."""
    parts = ["# Bodies and replies", "Fields with a star are required."]
    for name, schema in sorted(document["components"]["schemas"].items()):
        lines = [f"## {name} {{ #{ANCHORS}{name} }}"]
        if schema.get("description"):
            lines.append(schema["description"])
        if schema.get("properties"):
            lines.append(fields_table(schema))
        else:
            lines.append(f"{'One of: ' if 'enum' in schema else ''}{type_of(schema)}.")
        parts.append("\n\n".join(lines))
    return "\n\n".join(parts) + "\n"

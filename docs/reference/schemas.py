"""Types and fields of the OpenAPI document, as Markdown."""

import json
from typing import Any

Schema = dict[str, Any]
ANCHORS = "schema-"
_BOUNDS = {
    "minimum": ">= {}",
    "exclusiveMinimum": "> {}",
    "maximum": "<= {}",
    "exclusiveMaximum": "< {}",
    "minLength": "at least {} characters",
    "maxLength": "at most {} characters",
    "minItems": "at least {} items",
    "maxItems": "at most {} items",
}


def cell(text: str) -> str:
    """Return a text that a cell of a table can hold."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def type_of(schema: Schema) -> str:
    """Return the type of a value in words, with links to other schemas."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        return f"[{name}](schemas.md#{ANCHORS}{name})"
    if "enum" in schema or "const" in schema:
        return ", ".join(f"`{value}`" for value in schema.get("enum", [schema.get("const")]))
    choices = [one for key in ("anyOf", "oneOf", "allOf") for one in schema.get(key, ())]
    if choices:
        return " or ".join(type_of(one) for one in choices)
    return _container(schema)


def _container(schema: Schema) -> str:
    kind = schema.get("type", "any value")
    if kind == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})]
        return "array of " + ", ".join(dict.fromkeys(type_of(one) for one in items))
    if kind == "object" and isinstance(schema.get("additionalProperties"), dict):
        return "object of " + type_of(schema["additionalProperties"])
    return str(kind)


def fields_table(schema: Schema) -> str:
    """Return the table of an object's fields."""
    required = schema.get("required", ())
    rows = []
    for name, field in schema["properties"].items():
        star = " *" if name in required else ""
        default = f"`{json.dumps(field['default'])}`" if "default" in field else ""
        bounds = ", ".join(_bounds(field))
        meaning = cell(field.get("description", ""))
        rows.append(f"| `{name}`{star} | {type_of(field)} | {cell(bounds)} | {cell(default)} | {meaning} |")
    return "\n".join(["| field | type | bounds | default | meaning |", "|---|---|---|---|---|", *rows])


def _bounds(field: Schema) -> list[str]:
    bounded = [field, *field.get("anyOf", ())]
    return [words.format(f"{one[key]:g}") for one in bounded for key, words in _BOUNDS.items() if key in one]

"""Names that a JSON schema allows at a place of a body, and the nearest of them to a misspelt one."""

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

Schema = Mapping[str, Any]

_COMBINED = ("anyOf", "oneOf", "allOf")


def property_names(root: Schema, definitions: Mapping[str, Schema], place: Sequence[str | int]) -> list[str]:
    """Return the names of an object's properties, sorted; none where they are not known.

    Parameters
    ----------
    root
        Schema of the whole body.
    definitions
        Schemas by the last part of a `$ref`.
    place
        Keys and indices from the body to the object, as pydantic gives them: with the tag of a
        discriminated union, or the class name of one alternative, among them.
    """
    schemas = list(_alternatives(root, definitions))
    for part in place:
        schemas = [branch for schema in schemas for branch in _step(schema, definitions, part)] or schemas
    return sorted({name for schema in schemas for name in schema.get("properties", {})})


def suggestion(name: str, candidates: Sequence[str]) -> str:
    """Return "; did you mean `x`?" with the nearest allowed name, or nothing where none is near."""
    near = get_close_matches(name, candidates, n=1)
    return f"; did you mean `{near[0]}`?" if near else ""


def _alternatives(schema: Schema, definitions: Mapping[str, Schema]) -> Iterator[Schema]:
    """Yield the schemas that a value may have, references followed and combinations taken apart."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        for branch in _alternatives(definitions[name], definitions):
            yield {"x-name": name, **branch}
        return
    branches = [branch for key in _COMBINED for branch in schema.get(key, ())]
    if not branches:
        yield schema
        return
    tags = {ref: tag for tag, ref in schema.get("discriminator", {}).get("mapping", {}).items()}
    for branch in branches:
        tag = tags.get(branch.get("$ref"))
        for inner in _alternatives(branch, definitions):
            yield inner if tag is None else {"x-tag": tag, **inner}


def _step(schema: Schema, definitions: Mapping[str, Schema], part: str | int) -> Iterator[Schema]:
    """Yield the schemas one key, index, tag or class name further into a value."""
    if part in (schema.get("x-tag"), schema.get("x-name")):
        yield schema
        return
    following: Any = None
    if isinstance(part, int):
        prefix = schema.get("prefixItems", [])
        following = prefix[part] if part < len(prefix) else schema.get("items")
    else:
        following = schema.get("properties", {}).get(part, schema.get("additionalProperties"))
    if isinstance(following, Mapping):
        yield from _alternatives(following, definitions)

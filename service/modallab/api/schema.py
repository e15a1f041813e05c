"""Parts of JSON Schema that the OpenAPI document shows while the numerical code enforces them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema

from modallab.core.parameters import ParameterSpec

Json = dict[str, Any]


@dataclass(frozen=True)
class Limits:
    """Bounds of a number: keywords of JSON Schema, shown and not enforced here.

    The dataclass that takes the number refuses it with a code and a field name of its own, which a
    bound of pydantic would replace by `invalid_request`.

    Parameters
    ----------
    lower, upper
        Bounds; None where there is none.
    above, below
        True where the lower, or the upper, bound itself is excluded.
    """

    lower: float | None = None
    upper: float | None = None
    lower_excluded: bool = False
    upper_excluded: bool = False

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> Json:
        schema = dict(handler(core))
        if self.lower is not None:
            schema.pop("minimum", None)
            schema["exclusiveMinimum" if self.lower_excluded else "minimum"] = self.lower
        if self.upper is not None:
            schema.pop("maximum", None)
            schema["exclusiveMaximum" if self.upper_excluded else "maximum"] = self.upper
        return schema


@dataclass(frozen=True)
class OneOf:
    """The closed set of names that a text may be, read from a family when the document is made."""

    names: Callable[[], Iterable[str]]
    doc: str = ""

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> Json:
        described = {"description": self.doc} if self.doc else {}
        return {"type": "string", "enum": sorted(self.names())} | described


@dataclass(frozen=True)
class Pattern:
    """Regular expression of a text that is parsed elsewhere: shown and not enforced here."""

    pattern: str

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> Json:
        return dict(handler(core)) | {"pattern": self.pattern}


@dataclass(frozen=True)
class NamedByPattern:
    """Names of an object by `propertyNames`: generators of clients do not know `patternProperties`."""

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> Json:
        schema = dict(handler(core))
        ((pattern, value),) = schema.pop("patternProperties").items()
        names = {"pattern": pattern} | schema.get("propertyNames", {})
        return schema | {"propertyNames": names, "additionalProperties": value}


@dataclass(frozen=True)
class Specified:
    """Unit, meaning and bounds of a number from the specification that its dataclass declares."""

    spec: ParameterSpec

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> Json:
        bounds = {"minimum": self.spec.lower, "maximum": self.spec.upper}
        return dict(handler(core)) | bounds | {"description": f"{self.spec.unit}, {self.spec.doc}"}

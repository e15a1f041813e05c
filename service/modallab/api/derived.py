"""Request models derived from options dataclasses, so that an option is declared in one place."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from enum import StrEnum
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import (
    ConfigDict,
    GetCoreSchemaHandler,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    create_model,
)
from pydantic import Field as WireField
from pydantic_core import CoreSchema, core_schema

from modallab.api.limits import REQUEST
from modallab.api.schema import Limits, OneOf
from modallab.api.wire import NO_CONVERSION, Count, Number, Text, Wire
from modallab.core.options import Options, OptionSpec, unknown_option

OptionsT = TypeVar("OptionsT", bound=Options)


class DerivedBody(Wire):
    """Base of derived request models: their descriptions are declared, not searched in source."""

    model_config = ConfigDict(use_attribute_docstrings=False)


def body_of(cls: type[Options], *, enforced: bool = False, **wire_types: Any) -> type[Wire]:
    """Return the request model of an options dataclass: same names, defaults, bounds, choices and texts.

    Bounds and choices stand in the JSON schema.

    Parameters
    ----------
    enforced
        Whether the request model enforces them, as `invalid_request`, with the path of the field in the
        body; else the dataclass alone does, and names the option.
    wire_types
        Types of options whose JSON is not that of their annotation.
    """
    hints = get_type_hints(cls)
    specs = cls.specs()
    derive = _WireTypes(enforced)
    declared = {
        f.name: (
            wire_types[f.name] if f.name in wire_types else derive.type(hints[f.name], specs[f.name], f),
            _field(f, specs[f.name]),
        )
        for f in fields(cls)  # type: ignore[arg-type]
        if f.name in specs
    }
    model: Any = create_model(cls.__name__, __base__=DerivedBody, __doc__=cls.__doc__, **declared)  # type: ignore[call-overload]
    return model  # type: ignore[no-any-return]


def options_from(cls: type[OptionsT], body: Wire) -> OptionsT:
    """Return the options that a request states; those left out have their defaults.

    Raises
    ------
    InvalidInputError
        If one is out of bounds, or an option of another method.
    """
    refuse_foreign(body)
    hints = get_type_hints(cls)
    declared = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    stated = {name: getattr(body, name) for name in body.model_fields_set if name in declared}
    return cls(**{name: _value(hints[name], declared[name], value) for name, value in stated.items()})


def refuse_foreign(body: Wire) -> None:
    """Raise `InvalidInputError` where an option of another method was given."""
    if isinstance(body, ForeignOption):
        raise unknown_option(body.method, body.name, body.value, body.allowed)


class ForeignOption(Wire):
    """An option of another method than the one named: refused by whoever reads the body."""

    method: str
    name: str
    value: Any
    allowed: list[str]


class OptionsByMethod:
    """Annotation of a field `options` that holds those of the method named by the field `method`.

    The JSON schema is one of the methods' option models; a method that does not exist is left to whoever
    reads the body. An option of null is an option left out, whatever the method. Options without a method
    are those of the method `default`.
    """

    def __init__(self, bodies: Mapping[str, type[Wire]], default: str | None = None) -> None:
        self._bodies = bodies
        self._default = default

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        models = tuple(dict.fromkeys(self._bodies.values()))
        alternatives = handler.generate_schema(Union[models])  # noqa: UP007
        return core_schema.with_info_wrap_validator_function(self._validate, alternatives)

    def _validate(self, value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        method = info.data.get("method", "")
        method = self._default if method is None else method
        if not isinstance(method, str) or method not in self._bodies:
            return Wire()
        body = self._bodies[method]
        if isinstance(value, Mapping):
            names = self._option_names()
            value = {name: item for name, item in value.items() if item is not None or name not in names}
            foreign_names = names - body.model_fields.keys()
            for name in value.keys() & foreign_names:
                return ForeignOption(
                    method=method, name=name, value=value[name], allowed=[*body.model_fields]
                )
        return body.model_validate(value)

    def _option_names(self) -> set[str]:
        """Return the names of all methods' options."""
        return {name for body in self._bodies.values() for name in body.model_fields}


def _field(declared: Field[Any], spec: OptionSpec) -> Any:
    unit = f", {spec.unit}" if spec.unit not in ("", "1", "-") else ""
    described = f"{spec.doc}{unit}"
    if declared.default_factory is not MISSING:
        return WireField(default_factory=declared.default_factory, description=described)
    if is_dataclass(declared.default):  # its fields are those of a nested model, with their own defaults
        return WireField(default_factory=dict, validate_default=True, description=described)
    default = declared.default.value if isinstance(declared.default, StrEnum) else declared.default
    if default is None and declared.metadata["null_name"]:
        default = declared.metadata["null_name"]
    return WireField(default=default, description=described)


@dataclass(frozen=True)
class _WireTypes:
    """Types of a request's fields, derived from those of a dataclass."""

    enforced: bool
    """Whether the types refuse what is out of bounds."""

    def type(self, hint: Any, spec: OptionSpec, declared: Field[Any]) -> Any:  # noqa: PLR0911 - one return for each kind of type
        """Return the type of a request's field."""
        if get_origin(hint) in (Union, UnionType):
            name = declared.metadata["null_name"]
            null = Literal[name] if name else None
            members = (null if h is NoneType else self.type(h, spec, declared) for h in get_args(hint))
            return Union[tuple(members)]  # noqa: UP007
        if isinstance(hint, type) and issubclass(hint, Options):
            return body_of(hint, enforced=self.enforced)
        if spec.choices:
            return hint if self.enforced else Annotated[Text, OneOf(_names(spec.choices))]
        if hint is bool:
            return bool
        if hint in (int, float):
            return self._number(hint, spec)
        if hint is str:
            return Text
        if get_origin(hint) is tuple and Ellipsis not in get_args(hint):
            return tuple[tuple(self.type(h, spec, declared) for h in get_args(hint))]  # type: ignore[misc]
        if get_origin(hint) is tuple:
            shortest, longest = (declared.metadata[name] for name in ("min_items", "max_items"))
            entries = self.type(get_args(hint)[0], spec, declared)
            return Annotated[list[entries], WireField(min_length=shortest, max_length=longest)]  # type: ignore[valid-type]
        raise TypeError(f"{declared.name}: no request field is derived from {hint}")

    def _number(self, hint: Any, spec: OptionSpec) -> Any:
        bounded = (spec.lower, spec.upper, spec.exclusive_minimum) != (None, None, None)
        beyond = hint is int and (spec.upper or 0) > REQUEST.integer
        if beyond or (self.enforced and bounded):
            return Annotated[
                hint, WireField(ge=spec.lower, le=spec.upper, gt=spec.exclusive_minimum), NO_CONVERSION
            ]
        lower, excluded = (
            (spec.lower, False) if spec.exclusive_minimum is None else (spec.exclusive_minimum, True)
        )
        return Annotated[Count if hint is int else Number, Limits(lower, spec.upper, lower_excluded=excluded)]


def _names(choices: Iterable[str]) -> Any:
    return lambda: choices


def _value(hint: Any, declared: Field[Any], value: Any) -> Any:
    if value is not None and value == declared.metadata["null_name"]:
        return None
    if isinstance(value, Wire):
        nested = [h for h in (hint, *get_args(hint)) if isinstance(h, type) and issubclass(h, Options)]
        return options_from(nested[0], value) if nested else value
    return tuple(value) if isinstance(value, list) else value

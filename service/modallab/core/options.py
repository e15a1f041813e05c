"""Options of tasks and methods: default, unit, bounds, choices and meaning, declared once with the field."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from enum import StrEnum
from functools import cache
from typing import Any, ClassVar, Literal, TypeVar, get_args, get_type_hints

from modallab.core.errors import InvalidInputError, bounds


@dataclass(frozen=True)
class OptionSpec:
    """Specification of one option; a default of null stands for a value chosen from the data."""

    kind: ClassVar[Literal["option"]] = "option"
    doc: str
    """Meaning, in one line."""
    unit: str = ""
    """SI unit; `1` of a count or a ratio; empty where the option is no number."""
    lower: float | None = None
    """Smallest value allowed."""
    upper: float | None = None
    """Largest value allowed."""
    choices: tuple[str, ...] = ()
    """Names allowed; empty where the option is no name of a closed set."""
    default: float | str | None = None
    """Value of an option left out."""
    exclusive_minimum: float | None = None
    """Bound that a value must exceed."""


def option(
    default: Any = MISSING,
    *,
    doc: str,
    unit: str = "",
    lower: float | None = None,
    upper: float | None = None,
    exclusive_minimum: float | None = None,
    choices: tuple[str, ...] = (),
    default_factory: Any = MISSING,
    min_items: int | None = None,
    max_items: int | None = None,
    null_name: str = "",
) -> Any:
    """Declare a field of an options dataclass.

    Parameters
    ----------
    default, default_factory
        As of `dataclasses.field`.
    doc, unit, lower, upper, exclusive_minimum
        As of `OptionSpec`.
    choices
        Names allowed; not needed where the field's type is a StrEnum.
    min_items, max_items
        Smallest and largest number of entries of a sequence.
    null_name
        Name that stands for None in a request; empty where null itself does.
    """
    spec = OptionSpec(doc, unit, lower, upper, choices, exclusive_minimum=exclusive_minimum)
    metadata = {"option": spec, "min_items": min_items, "max_items": max_items, "null_name": null_name}
    if default_factory is not MISSING:
        return field(default_factory=default_factory, metadata=metadata)
    return field(default=default, metadata=metadata)


class Options:
    """Mix-in for frozen dataclasses with `option` fields.

    A class whose options stand within those of another states their path in `options_path`, as
    `tolerances.`: errors then name `tolerances.delay`.

    Raises
    ------
    InvalidInputError
        If a number is out of its bounds, or a name is not among the choices.
    """

    options_path: ClassVar[str] = ""

    @classmethod
    def specs(cls) -> dict[str, OptionSpec]:
        """Return the specification of every option by name."""
        declared: Any = cls
        return dict(_specs(declared))

    def __post_init__(self) -> None:
        for name, spec in self.specs().items():
            value = getattr(self, name)
            if isinstance(value, str) and spec.choices:
                object.__setattr__(self, name, _chosen(type(self), name, value, spec))
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                _check_bounds(self.options_path + name, value, spec)


@cache
def enumeration(cls: type, name: str) -> type[StrEnum] | None:
    """Return the StrEnum in the annotation of a field, `X` or `X | None`; None if there is none."""
    hint = get_type_hints(cls)[name]
    for candidate in (hint, *get_args(hint)):
        if isinstance(candidate, type) and issubclass(candidate, StrEnum):
            return candidate
    return None


@cache
def _specs(cls: Any) -> Mapping[str, OptionSpec]:
    return {f.name: _spec(cls, f) for f in fields(cls) if "option" in f.metadata}


def _spec(cls: type, declared: Field[Any]) -> OptionSpec:
    spec: OptionSpec = declared.metadata["option"]
    names = enumeration(cls, declared.name)
    default = None if declared.default is MISSING else declared.default
    return replace(
        spec,
        choices=spec.choices if names is None else tuple(member.value for member in names),
        default=default.value if isinstance(default, StrEnum) else default,
    )


def _chosen(cls: type, name: str, value: str, spec: OptionSpec) -> str:
    """Return a name that is among the choices, as a member of the field's StrEnum where it has one."""
    if value not in spec.choices:
        raise InvalidInputError(
            f"there is no {name} {str(value)!r}",
            field=name,
            value=str(value),
            allowed=list(spec.choices),
        )
    names = enumeration(cls, name)
    return value if names is None else names(value)


def _check_bounds(path: str, value: float, spec: OptionSpec) -> None:
    lower = -math.inf if spec.lower is None else spec.lower
    upper = math.inf if spec.upper is None else spec.upper
    inside = lower <= value <= upper and (
        spec.exclusive_minimum is None or value > spec.exclusive_minimum
    )  # NaN is outside
    bounded = (spec.lower, spec.upper, spec.exclusive_minimum) != (None, None, None)
    if bounded and not inside:
        raise InvalidInputError(
            f"{path} is out of bounds",
            field=path,
            value=value,
            allowed=bounds(spec.lower, spec.upper, exclusive_minimum=spec.exclusive_minimum, unit=spec.unit),
        )


OptionsT = TypeVar("OptionsT", bound=Options)


def converted(
    options: Options | None, expected: type[OptionsT], method: str, reasons: Mapping[str, str] | None = None
) -> OptionsT:
    """Return options as those of a method.

    Parameters
    ----------
    options
        Of the type expected, or with some of its fields, as a base class that methods have in common; None
        for the defaults.
    expected
        Options dataclass of the method.
    method
        Name of the method, for a refusal.
    reasons
        Why the method has no option of a name.

    Raises
    ------
    InvalidInputError
        If an option was given that the method does not have.
    """
    if type(options) is expected:
        return options
    given = {} if options is None else {name: getattr(options, name) for name in options.specs()}
    allowed = expected.specs()
    for name in given.keys() - allowed.keys():
        if given[name] != options.specs()[name].default and given[name]:  # type: ignore[union-attr]
            raise unknown_option(method, name, given[name], allowed, reasons)
    return expected(**{name: value for name, value in given.items() if name in allowed})


def unknown_option(
    method: str,
    name: str,
    value: Any,
    allowed: Iterable[str],
    reasons: Mapping[str, str] | None = None,
) -> InvalidInputError:
    """Return the error of an option that a method does not have."""
    reason = (reasons or {}).get(name, "")
    return InvalidInputError(
        f"{method} has no option {name!r}{reason and ': '}{reason}",
        field=name,
        value=value,
        allowed=list(allowed),
    )

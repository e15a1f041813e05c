"""Numbers that may be fitted: unit, bounds and meaning said once, where the number is declared."""

from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, ClassVar, Literal

from modallab.core.errors import InvalidInputError, bounds


@dataclass(frozen=True)
class ParameterSpec:
    """Specification of a parameter that may be fitted."""

    kind: ClassVar[Literal["parameter"]] = "parameter"
    unit: str
    """SI unit; `1` of a ratio."""
    lower: float
    """Smallest value allowed."""
    upper: float
    """Largest value allowed."""
    absent: float | None
    """Value at which the effect vanishes; None where another parameter gives its size."""
    doc: str
    """Meaning, in one line."""
    scan_values: tuple[float, ...] = ()
    """Initial values of a fit; without any they are spread about the default."""
    optional_start: float | None = None
    """Initial value of a fit, of one that keeps its default unless the data ask for more; None of others."""
    alternative: float | None = None
    """Value that a diagnosis tries beside the default, of a choice that no fit varies; None of others."""
    chosen: bool = False
    """Whether it is a choice that no fit varies, among values that depend on the structure."""

    @property
    def signed(self) -> bool:
        """Whether it may be negative, so that no logarithm of it can be taken."""
        return self.lower < 0

    def other_choice(self, value: float, default: float) -> float | None:
        """Return the other value of a choice: its alternative, or its default beside that."""
        return default if value == self.alternative else self.alternative


def parameter(
    default: float,
    *,
    unit: str,
    lower: float,
    upper: float,
    doc: str,
    absent: float | None = 0.0,
    scan_values: tuple[float, ...] = (),
    optional_start: float | None = None,
    alternative: float | None = None,
    chosen: bool = False,
) -> Any:
    """Declare a dataclass field that may be fitted; unit and bounds live here only."""
    spec = ParameterSpec(unit, lower, upper, absent, doc, scan_values, optional_start, alternative, chosen)
    return field(default=default, metadata={"spec": spec})


def share_parameter(*, doc: str, scan_values: tuple[float, ...] = ()) -> Any:
    """Declare a share, 1 by default; no fit varies it, and a diagnosis tries 0 too."""
    return parameter(
        1.0,
        unit="1",
        lower=0.0,
        upper=1.0,
        absent=None,
        doc=doc,
        scan_values=scan_values,
        alternative=0.0,
    )


class Parameterised:
    """Mix-in for frozen dataclasses with `parameter` fields."""

    @classmethod
    def specs(cls) -> dict[str, ParameterSpec]:
        """Return the specification of every fitted number by name."""
        own: Any = cls
        return dict(_specs(own))

    def __post_init__(self) -> None:
        for name, spec in self.specs().items():
            value = getattr(self, name)
            if not spec.lower <= value <= spec.upper:  # NaN fails too
                raise InvalidInputError(
                    f"{name} is out of bounds",
                    field=name,
                    value=value,
                    allowed=bounds(spec.lower, spec.upper, unit=spec.unit),
                )


@cache
def _specs(cls: Any) -> dict[str, ParameterSpec]:
    return {f.name: f.metadata["spec"] for f in fields(cls) if "spec" in f.metadata}

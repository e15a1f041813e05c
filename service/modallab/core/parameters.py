"""Numbers that may be fitted: unit, bounds and meaning said once, where the number is declared."""

from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from modallab.core.errors import InvalidInputError


@dataclass(frozen=True)
class ParameterSpec:
    """Meaning and bounds of a fitted parameter.

    `absent` is the value at which it has no effect; None where it only says how the effect acts, and
    another number how much. `scan_values` are values worth a first look; without any they are spread
    about the default.
    """

    unit: str
    lower: float
    upper: float
    absent: float | None
    doc: str
    scan_values: tuple[float, ...] = ()

    @property
    def signed(self) -> bool:
        """Whether it may be negative, so that no logarithm of it can be taken."""
        return self.lower < 0


def parameter(
    default: float,
    *,
    unit: str,
    lower: float,
    upper: float,
    doc: str,
    absent: float | None = 0.0,
    scan_values: tuple[float, ...] = (),
) -> Any:
    """Declare a dataclass field that may be fitted; unit and bounds live here only."""
    return field(
        default=default, metadata={"spec": ParameterSpec(unit, lower, upper, absent, doc, scan_values)}
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
                    allowed=f"{spec.lower} to {spec.upper} {spec.unit}",
                )


@cache
def _specs(cls: Any) -> dict[str, ParameterSpec]:
    return {f.name: f.metadata["spec"] for f in fields(cls) if "spec" in f.metadata}

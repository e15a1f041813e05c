"""Settings of an algorithm: every number that decides how it behaves, with unit, meaning and origin."""

from dataclasses import dataclass, field, fields
from typing import Any

JUDGEMENT = "chosen by judgement; not studied"
"""Origin of a setting that no test and no data have examined."""


@dataclass(frozen=True)
class SettingSpec:
    """Meaning and origin of a setting.

    `derived` names the argument that fixes the value, `tuned` the data on which the value was chosen;
    exactly one of them is given.
    """

    unit: str
    doc: str
    derived: str = ""
    tuned: str = ""

    def __post_init__(self) -> None:
        if bool(self.derived) == bool(self.tuned):
            raise ValueError("a setting is either derived or tuned")


def setting(default: Any, *, unit: str = "1", doc: str, derived: str = "", tuned: str = "") -> Any:
    """Declare a field of a settings dataclass.

    Parameters
    ----------
    default
        A number, or a tuple of numbers.
    unit
        SI, or what is counted: `modes`, `lines`, `standard errors`; `1` of a ratio.
    doc
        What the number decides.
    derived, tuned
        Why it has this value: `derived="3 sigma: one of 370 by chance"`, or `tuned="blind trial, set 1"`.
    """
    return field(default=default, metadata={"setting": SettingSpec(unit, doc, derived, tuned)})


@dataclass(frozen=True)
class Settings:
    """Base of all settings dataclasses; a module holds one instance, in capitals, that the code reads."""

    @classmethod
    def specs(cls) -> dict[str, SettingSpec]:
        """Return the specification of every setting by name."""
        return {f.name: f.metadata["setting"] for f in fields(cls)}

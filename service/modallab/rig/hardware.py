"""The hardware of a rig as its data sheets have it; parts left out are ideal."""

from dataclasses import dataclass
from typing import Literal

from modallab.core.errors import InvalidInputError


def within(name: str, value: float, lower: float, upper: float) -> None:
    """Raise `InvalidInputError` unless a declared number lies between its bounds."""
    if not lower <= value <= upper:  # NaN fails too
        raise InvalidInputError(
            f"{name} is out of bounds", field=name, value=value, allowed=f"{lower} to {upper}"
        )


# The bounds below are those of the effects that the hardware implies: what a log book may declare,
# an effect can be (an armature may have the gauge's cancelled mass to carry as well).
@dataclass(frozen=True)
class Exciter:
    """What drives the structure."""

    kind: Literal["shaker", "hammer"] = "shaker"
    armature_mass: float = 0.0  # kg, behind the force transducer

    def __post_init__(self) -> None:
        within("armature_mass", self.armature_mass, 0.0, 4.5)


@dataclass(frozen=True)
class ForceTransducer:
    """The gauge at the drive point."""

    mass_below: float = 0.0  # kg, between the sensing element and the structure
    mass_cancelled: bool = False  # True: the analyser has taken that mass out of the force already

    def __post_init__(self) -> None:
        within("mass_below", self.mass_below, 0.0, 0.5)


@dataclass(frozen=True)
class Accelerometers:
    """The response transducers: one at every response DoF, or one that roves over them."""

    mass: float = 0.0  # kg each, with stud
    roving: bool = False

    def __post_init__(self) -> None:
        within("accelerometers.mass", self.mass, 0.0, 0.5)


@dataclass(frozen=True)
class Noise:
    """White noise as a ratio to the mean of the noise-free spectrum over the band."""

    force: float = 0.0
    response: float = 0.0

    def __post_init__(self) -> None:
        within("noise.force", self.force, 0.0, 10.0)
        within("noise.response", self.response, 0.0, 10.0)

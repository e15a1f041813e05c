"""Hardware of a rig as its data sheets declare it."""

import math
from dataclasses import dataclass
from typing import Literal

from modallab.core.errors import InvalidInputError
from modallab.rig.mounting import MOUNTINGS, Mounting


def within(name: str, value: float, lower: float, upper: float) -> None:
    """Raise `InvalidInputError` unless a declared number lies between its bounds."""
    if not lower <= value <= upper:  # NaN fails too
        raise InvalidInputError(
            f"{name} is out of bounds", field=name, value=value, allowed=f"{lower} to {upper}"
        )


# The bounds below are those of the effects that the hardware implies: what a log book may declare,
# an effect can be.
@dataclass(frozen=True)
class Coil:
    """The voice coil of a shaker."""

    force_factor: float  # N/A, and V s/m: B times the length of the wire
    resistance: float  # Ohm
    inductance: float = 0.0  # H

    def __post_init__(self) -> None:
        within("coil.force_factor", self.force_factor, 0.0, 100.0)
        within("coil.resistance", self.resistance, 0.1, 1e4)
        within("coil.inductance", self.inductance, 0.0, 0.1)


@dataclass(frozen=True)
class Exciter:
    """What drives the structure.

    An amplifier that keeps the coil's current leaves the coil without reaction on its motion; one
    that keeps the voltage damps it, by force_factor^2 / (resistance + i omega inductance).
    """

    kind: Literal["shaker", "hammer"] = "shaker"
    armature_mass: float = 0.0  # kg, behind the force transducer
    suspension_stiffness: float = 0.0  # N/m, armature to its frame
    suspension_damping: float = 0.0  # N s/m
    coil: Coil | None = None
    amplifier: Literal["current", "voltage"] = "current"

    def __post_init__(self) -> None:
        within("armature_mass", self.armature_mass, 0.0, 4.5)
        within("suspension_stiffness", self.suspension_stiffness, 0.0, 1e8)
        within("suspension_damping", self.suspension_damping, 0.0, 1e5)
        if self.amplifier == "voltage" and self.coil is None:
            raise InvalidInputError(
                "an amplifier that keeps the voltage needs to know the coil",
                field="exciter.coil",
                allowed="force_factor, resistance and inductance of the coil",
            )


@dataclass(frozen=True)
class ForceTransducer:
    """The gauge at the drive point."""

    mass_below: float = 0.0  # kg, between the sensing element and the structure
    mass_cancelled: bool = False  # True: the analyser has taken that mass out of the force already
    stiffness: float | None = None  # N/m, along its axis; None or 0: rigid

    def __post_init__(self) -> None:
        within("mass_below", self.mass_below, 0.0, 0.5)
        if self.stiffness:
            within("force_transducer.stiffness", self.stiffness, 1e3, 1e12)


@dataclass(frozen=True)
class Accelerometers:
    """The response transducers: one at every response DoF, or one that roves over them."""

    mass: float = 0.0  # kg each, with stud
    roving: bool = False
    mounting: Literal["ideal", "stud", "wax", "magnet"] = "ideal"
    mounted_frequency: float | None = None  # Hz; None: as the mounting has it
    transverse_sensitivity: float = 0.0  # across the axis over along it
    transverse_angle: float = 0.0  # rad about the axis, to the most sensitive direction
    cable_mass: float = 0.0  # kg each, of the cable that moves with it

    def __post_init__(self) -> None:
        within("accelerometers.mass", self.mass, 0.0, 0.5)
        within("accelerometers.cable_mass", self.cable_mass, 0.0, 0.5)
        if self.mounted_frequency is not None:
            within("accelerometers.mounted_frequency", self.mounted_frequency, 10.0, 1e9)
        within("accelerometers.transverse_sensitivity", self.transverse_sensitivity, -1.0, 1.0)
        within("accelerometers.transverse_angle", self.transverse_angle, -math.pi / 2, math.pi / 2)

    @property
    def effective_mounting(self) -> Mounting | None:
        """Mounted resonance; None if ideal."""
        mounting = MOUNTINGS.get(self.mounting)
        if self.mounted_frequency is None:
            return mounting
        return Mounting(self.mounted_frequency, (mounting or MOUNTINGS["stud"]).loss)


@dataclass(frozen=True)
class Noise:
    """White noise as a ratio to the mean of the noise-free spectrum over the band."""

    force: float = 0.0
    response: float = 0.0

    def __post_init__(self) -> None:
        within("noise.force", self.force, 0.0, 10.0)
        within("noise.response", self.response, 0.0, 10.0)

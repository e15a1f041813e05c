"""Wire types of the hardware; parts left out are ideal."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.wire import DofText, Number, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.rig.hardware import Accelerometers, Coil, Exciter, ForceTransducer, Noise
from modallab.rig.stinger import Stinger, StingerRod, StingerStiffness
from modallab.rig.suspension import Suspension


class CoilIn(Wire):
    """The voice coil of a shaker."""

    force_factor: Number
    resistance: Number
    inductance: Number = 0.0

    def to_domain(self) -> Coil:
        """Return the coil."""
        return Coil(self.force_factor, self.resistance, self.inductance)


class ExciterIn(Wire):
    """What drives the structure."""

    kind: Literal["shaker", "hammer"] = "shaker"
    armature_mass: Number = 0.0
    suspension_stiffness: Number = 0.0
    suspension_damping: Number = 0.0
    coil: CoilIn | None = None
    amplifier: Literal["current", "voltage"] = "current"

    def to_domain(self) -> Exciter:
        """Return the exciter."""
        return Exciter(
            self.kind,
            self.armature_mass,
            self.suspension_stiffness,
            self.suspension_damping,
            self.coil.to_domain() if self.coil else None,
            self.amplifier,
        )


class StingerIn(Wire):
    """A stinger as a round rod, or by its stiffness."""

    diameter: Number | None = None
    length: Number | None = None
    modulus: Number | None = None
    density: Number | None = None
    axial_stiffness: Number | None = None
    bending_stiffness: Number | None = None
    lateral_stiffness: Number | None = None

    def to_domain(self) -> Stinger:
        """Return the stinger; `InvalidInputError` unless it is one or the other, and all of a rod."""
        rod = (self.diameter, self.length, self.modulus, self.density)
        springs = (self.axial_stiffness, self.bending_stiffness, self.lateral_stiffness)
        if any(value is not None for value in springs) == any(value is not None for value in rod):
            raise _stinger("a stinger is a rod, or stiffness")
        if all(value is None for value in rod):
            return StingerStiffness(springs[0], springs[1] or 0.0, springs[2] or 0.0)
        diameter, length, modulus, density = rod
        if diameter is None or length is None or modulus is None or density is None:
            raise _stinger("a rod needs all its dimensions")
        return StingerRod(diameter, length, modulus, density)


def _stinger(says: str) -> InvalidInputError:
    allowed = (
        "diameter, length, modulus and density; or axial_stiffness, bending_stiffness, lateral_stiffness"
    )
    return InvalidInputError(says, field="stinger", allowed=allowed)


class ForceTransducerIn(Wire):
    """The gauge at the drive point."""

    mass_below: Number = 0.0
    mass_cancelled: bool = False
    stiffness: Number | None = None

    def to_domain(self) -> ForceTransducer:
        """Return the force transducer."""
        return ForceTransducer(self.mass_below, self.mass_cancelled, self.stiffness)


class AccelerometersIn(Wire):
    """The response transducers."""

    mass: Number = 0.0
    roving: bool = False
    mounting: Literal["ideal", "stud", "wax", "magnet"] = "ideal"
    mounted_frequency: Number | None = None
    transverse_sensitivity: Number = 0.0
    transverse_angle: Number = 0.0
    cable_mass: Number = 0.0

    def to_domain(self) -> Accelerometers:
        """Return the accelerometers."""
        return Accelerometers(
            self.mass,
            self.roving,
            self.mounting,
            self.mounted_frequency,
            self.transverse_sensitivity,
            self.transverse_angle,
            self.cable_mass,
        )


class NoiseIn(Wire):
    """Noise as a ratio to the mean of each channel's noise-free spectrum."""

    force: Number = 0.0
    response: Number = 0.0

    def to_domain(self) -> Noise:
        """Return the noise."""
        return Noise(self.force, self.response)


class SuspensionIn(Wire):
    """The elastic bands that the structure hangs on, all alike."""

    at: Annotated[list[DofText], Field(min_length=1, max_length=100)]
    stiffness: Number
    loss_factor: Number = 0.0

    def to_domain(self) -> Suspension:
        """Return the suspension."""
        at = tuple(Dof.parse(text, field="suspension.at") for text in self.at)
        return Suspension(at, self.stiffness, self.loss_factor)

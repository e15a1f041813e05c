"""Wire types of the hardware; parts left out are ideal."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.schema import Limits, NamedByPattern
from modallab.api.wire import Fraction, NonNegative, Number, Translation, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.rig.hardware import Accelerometers, Coil, Exciter, ForceTransducer, Noise, NoiseDensity
from modallab.rig.stinger import Stinger, StingerRod, StingerStiffness
from modallab.rig.suspension import Suspension

Density = Annotated[Number, Limits(0.0, 1e12)]


class CoilIn(Wire):
    """The voice coil of a shaker."""

    force_factor: Annotated[Number, Limits(0.0, 100.0)]
    """N/A, force factor Bl"""
    resistance: Annotated[Number, Limits(0.1, 1e4)]
    """Ohm, resistance"""
    inductance: Annotated[Number, Limits(0.0, 0.1)] = 0.0
    """H, inductance"""

    def to_domain(self) -> Coil:
        """Return the coil."""
        return Coil(self.force_factor, self.resistance, self.inductance)


class ExciterIn(Wire):
    """What drives the structure."""

    kind: Literal["shaker", "hammer"] = "shaker"
    """kind of exciter"""
    armature_mass: Annotated[Number, Limits(0.0, 4.5)] = 0.0
    """kg, moving mass behind the force transducer"""
    suspension_stiffness: Annotated[Number, Limits(0.0, 1e8)] = 0.0
    """N/m, armature to shaker body"""
    suspension_damping: Annotated[Number, Limits(0.0, 1e5)] = 0.0
    """N s/m, armature to shaker body"""
    coil: CoilIn | None = None
    """voice coil; null: no reaction on the motion"""
    amplifier: Literal["current", "voltage"] = "current"
    """quantity that the power amplifier controls; `voltage` needs a coil"""

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

    diameter: Annotated[Number, Limits(1e-5, 0.1)] | None = None
    """m, of a round rod"""
    length: Annotated[Number, Limits(1e-3, 10.0)] | None = None
    """m, of the rod"""
    modulus: Annotated[Number, Limits(1e6, 1e13)] | None = None
    """N/m^2, modulus of elasticity of the rod"""
    density: Annotated[Number, Limits(1.0, 1e5)] | None = None
    """kg/m^3, of the rod"""
    axial_stiffness: Annotated[Number, Limits(1e3, 1e12)] | None = None
    """N/m, of a stinger given by stiffness; null: rigid"""
    bending_stiffness: Annotated[Number, Limits(0.0, 1e7)] | None = None
    """N m/rad, at the drive point"""
    lateral_stiffness: NonNegative | None = None
    """N/m, at the drive point"""

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


def _stinger(message: str) -> InvalidInputError:
    allowed = (
        "diameter, length, modulus and density; or axial_stiffness, bending_stiffness, lateral_stiffness"
    )
    return InvalidInputError(message, field="stinger", allowed=allowed)


class ForceTransducerIn(Wire):
    """The gauge at the drive point."""

    mass_below: Annotated[Number, Limits(0.0, 0.5)] = 0.0
    """kg, between the sensing element and the structure"""
    mass_cancelled: bool = False
    """true: that mass is subtracted from the force already"""
    stiffness: Annotated[Number, Limits(0.0, 1e12)] | None = None
    """N/m, axial; null or 0: rigid, else at least 1000"""

    def to_domain(self) -> ForceTransducer:
        """Return the force transducer."""
        return ForceTransducer(self.mass_below, self.mass_cancelled, self.stiffness)


class AccelerometersIn(Wire):
    """The response transducers."""

    mass: Annotated[Number, Limits(0.0, 0.5)] = 0.0
    """kg each"""
    roving: bool = False
    """true: one accelerometer moves from point to point"""
    mounting: Literal["ideal", "stud", "wax", "magnet"] = "ideal"
    """attachment, which has a resonance"""
    mounted_frequency: Annotated[Number, Limits(10.0, 1e9)] | None = None
    """Hz, resonance of the mounting; null: that of `mounting`"""
    transverse_sensitivity: Annotated[Number, Limits(-1.0, 1.0)] = 0.0
    """1, across the axis over along it"""
    transverse_angle: Annotated[Number, Limits(-1.5707963267948966, 1.5707963267948966)] = 0.0
    """rad, about the axis, direction of the largest transverse sensitivity"""
    cable_mass: Annotated[Number, Limits(0.0, 0.5)] = 0.0
    """kg each, mass of cable that moves with it"""

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


class NoiseDensityIn(Wire):
    """White noise by its absolute spectrum."""

    psd: Density | Annotated[dict[Translation, Density], NamedByPattern()]
    """unit^2/Hz, N^2/Hz or (m/s^2)^2/Hz: one value, or one for each channel by its degree of freedom"""

    def to_domain(self) -> NoiseDensity:
        """Return the noise."""
        return NoiseDensity(self.psd)


class NoiseIn(Wire):
    """Noise: a ratio to the mean of each channel's noise-free spectrum, or an absolute spectrum.

    A simulated test has none where it is unknown.
    """

    force: Annotated[Number, Limits(0.0, 10.0)] | NoiseDensityIn | None = None
    """1, noise over the mean of the force spectrum, or its density; null: unknown"""
    response: Annotated[Number, Limits(0.0, 10.0)] | NoiseDensityIn | None = None
    """1, noise over the mean of the response spectrum, or its density; null: unknown"""

    def to_domain(self) -> Noise:
        """Return the noise."""
        return Noise(_level(self.force), _level(self.response))


def _level(level: float | NoiseDensityIn | None) -> float | NoiseDensity | None:
    return level.to_domain() if isinstance(level, NoiseDensityIn) else level


class SuspensionIn(Wire):
    """The elastic bands that the structure hangs on, all alike."""

    at: Annotated[list[Translation], Field(min_length=1, max_length=100)]
    """degrees of freedom where a band pulls, translations"""
    stiffness: Annotated[Number, Limits(0.0, 1e9)]
    """N/m each"""
    loss_factor: Fraction = 0.0
    """1, loss factor"""

    def to_domain(self) -> Suspension:
        """Return the suspension."""
        at = tuple(Dof.parse(text, field="suspension.at") for text in self.at)
        return Suspension(at, self.stiffness, self.loss_factor)

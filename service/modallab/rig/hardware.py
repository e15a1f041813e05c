"""Hardware of a rig as its data sheets declare it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.rig.mounting import MOUNTINGS, Mounting


def within(name: str, value: float, lower: float, upper: float) -> None:
    """Raise `InvalidInputError` unless a declared number lies between its bounds."""
    if not lower <= value <= upper:  # NaN fails too
        raise InvalidInputError(
            f"{name} is out of bounds", field=name, value=value, allowed=bounds(lower, upper)
        )


# The bounds below are those of the effects that the hardware implies: what a log book may declare,
# an effect can be.
@dataclass(frozen=True)
class Coil:
    """The voice coil of a shaker."""

    force_factor: float
    """N/A, product of flux density and wire length."""
    resistance: float
    """Ohm, resistance of coil and amplifier."""
    inductance: float = 0.0
    """H, inductance of the coil."""

    def __post_init__(self) -> None:
        within("coil.force_factor", self.force_factor, 0.0, 100.0)
        within("coil.resistance", self.resistance, 0.1, 1e4)
        within("coil.inductance", self.inductance, 0.0, 0.1)


@dataclass(frozen=True)
class Exciter:
    """Exciter of the structure.

    If the amplifier controls the current, the motion of the coil causes no force. If it controls the voltage,
    the back-EMF of the coil damps the motion by force_factor^2 / (resistance + i omega inductance).
    """

    kind: Literal["shaker", "hammer"] = "shaker"
    """`shaker` or `hammer`."""
    armature_mass: float = 0.0
    """kg, moving mass behind the force transducer."""
    suspension_stiffness: float = 0.0
    """N/m, suspension of the armature."""
    suspension_damping: float = 0.0
    """N s/m, suspension of the armature."""
    coil: Coil | None = None
    """Voice coil; None: ideal."""
    amplifier: Literal["current", "voltage"] = "current"
    """Quantity that the amplifier controls: `current` or `voltage`."""

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

    mass_below: float = 0.0
    """kg, mass between sensing element and structure."""
    mass_cancelled: bool = False
    """Whether the analyser has subtracted the inertia of that mass."""
    stiffness: float | None = None
    """N/m, axial stiffness; None or 0: rigid."""

    def __post_init__(self) -> None:
        within("mass_below", self.mass_below, 0.0, 0.5)
        if self.stiffness:
            within("force_transducer.stiffness", self.stiffness, 1e3, 1e12)


@dataclass(frozen=True)
class Accelerometers:
    """The response transducers: one at every response DoF, or one that roves over them."""

    mass: float = 0.0
    """kg, of each accelerometer with its stud."""
    roving: bool = False
    """Whether one accelerometer roves over all responses."""
    mounting: Literal["ideal", "stud", "wax", "magnet"] = "ideal"
    """Kind of mounting."""
    mounted_frequency: float | None = None
    """Hz, mounted resonance; None: typical of the mounting."""
    transverse_sensitivity: float = 0.0
    """1, transverse over axial sensitivity."""
    transverse_angle: float = 0.0
    """rad, direction of the transverse sensitivity about the axis."""
    cable_mass: float = 0.0
    """kg, mass of the cable that moves with each accelerometer."""

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
class NoiseDensity:
    """White noise by its absolute spectrum."""

    psd: float | Mapping[str, float]
    """unit^2/Hz, N^2/Hz of forces and (m/s^2)^2/Hz of responses: one value, or one a channel by its DoF."""

    def __post_init__(self) -> None:
        for value in self.psd.values() if isinstance(self.psd, Mapping) else (self.psd,):
            within("noise.psd", value, 0.0, _MAX_DENSITY)

    def of(self, dof: Dof) -> float:
        """Return the density of a channel, unit^2/Hz; the mean of all where none is stated for it."""
        if not isinstance(self.psd, Mapping):
            return self.psd
        densities = {Dof.parse(name).point: value for name, value in self.psd.items()}
        return densities.get(dof.point, sum(densities.values()) / len(densities))

    def check_channels(self, field: str, dofs: Sequence[Dof]) -> None:
        """Raise `InvalidInputError` unless densities by channel are those of the channels at `dofs`."""
        if not isinstance(self.psd, Mapping):
            return
        stated = {Dof.parse(name, field=field).point for name in self.psd}
        if stated != {dof.point for dof in dofs}:
            raise InvalidInputError(
                "noise by channel is one density for each channel",
                field=field,
                value=list(self.psd),
                allowed=[str(dof) for dof in dofs],
            )


_MAX_DENSITY = 1e12  # of input, far beyond any signal


@dataclass(frozen=True)
class Noise:
    """White noise of the channels, a ratio to the mean noise-free spectrum of the band or a density.

    Of a simulated test unknown noise is none.
    """

    force: float | NoiseDensity | None = 0.0
    """1 or a density, of the force channels; None: unknown."""
    response: float | NoiseDensity | None = 0.0
    """1 or a density, of the response channels; None: unknown."""

    def __post_init__(self) -> None:
        for name in ("force", "response"):
            level = getattr(self, name)
            if isinstance(level, float | int):
                within(f"noise.{name}", level, 0.0, 10.0)

    @property
    def force_ratio(self) -> float:
        """1, ratio of the force channels; 0 of an absolute or unknown noise."""
        return _ratio(self.force)

    @property
    def response_ratio(self) -> float:
        """1, ratio of the response channels; 0 of an absolute or unknown noise."""
        return _ratio(self.response)

    @property
    def absolute(self) -> bool:
        """Whether the noise of either side is a density."""
        return isinstance(self.force, NoiseDensity) or isinstance(self.response, NoiseDensity)

    def densities(self, forces: Sequence[Dof], responses: Sequence[Dof]) -> list[float]:
        """Return the absolute noise of force channels, then of response channels, unit^2/Hz."""
        parts = ((self.force, forces), (self.response, responses))
        return [
            level.of(dof) if isinstance(level, NoiseDensity) else 0.0 for level, dofs in parts for dof in dofs
        ]


def _ratio(level: float | NoiseDensity | None) -> float:
    return float(level) if isinstance(level, float | int) else 0.0

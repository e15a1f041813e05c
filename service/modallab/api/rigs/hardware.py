"""Wire types of the hardware; parts left out are ideal."""

from typing import Literal

from modallab.api.wire import Number, Wire
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise


class ExciterIn(Wire):
    """What drives the structure."""

    kind: Literal["shaker"] = "shaker"
    armature_mass: Number = 0.0

    def to_domain(self) -> Exciter:
        """Return the exciter."""
        return Exciter(self.kind, self.armature_mass)


class ForceTransducerIn(Wire):
    """The gauge at the drive point."""

    mass_below: Number = 0.0
    mass_cancelled: bool = False

    def to_domain(self) -> ForceTransducer:
        """Return the force transducer."""
        return ForceTransducer(self.mass_below, self.mass_cancelled)


class AccelerometersIn(Wire):
    """The response transducers."""

    mass: Number = 0.0
    roving: bool = False

    def to_domain(self) -> Accelerometers:
        """Return the accelerometers."""
        return Accelerometers(self.mass, self.roving)


class NoiseIn(Wire):
    """Noise as a ratio to the mean of each channel's noise-free spectrum."""

    force: Number = 0.0
    response: Number = 0.0

    def to_domain(self) -> Noise:
        """Return the noise."""
        return Noise(self.force, self.response)

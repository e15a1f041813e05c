"""Damping laws of a structure."""

from dataclasses import dataclass

from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.structure_settings import INPUT

# Of built-up metal structures, 0.001 to 0.1, the middle on a logarithmic scale.
UNKNOWN_LOSS_FACTOR = 0.01


def _not_negative(name: str, *values: float) -> None:
    for value in values:
        if not 0 <= value <= INPUT.max_damping:  # NaN fails too
            allowed = bounds(0, INPUT.max_damping)
            raise InvalidInputError(f"{name} must not be negative", field=name, value=value, allowed=allowed)


@dataclass(frozen=True)
class StructuralDamping:
    """Hysteretic: D = a M + b K, so that eta_r = a / lambda_r + b."""

    stiffness_coefficient: float = 0.0  # b
    mass_coefficient: float = 0.0  # a, rad^2/s^2

    def __post_init__(self) -> None:
        _not_negative("stiffness_coefficient", self.stiffness_coefficient)
        _not_negative("mass_coefficient", self.mass_coefficient)


@dataclass(frozen=True)
class UnknownDamping(StructuralDamping):
    """Structural damping of which nothing is known: 1 % of every mode where a number is needed."""

    stiffness_coefficient: float = UNKNOWN_LOSS_FACTOR


@dataclass(frozen=True)
class ViscousDamping:
    """C = a M + b K."""

    stiffness_coefficient: float = 0.0  # b, s
    mass_coefficient: float = 0.0  # a, 1/s

    def __post_init__(self) -> None:
        _not_negative("stiffness_coefficient", self.stiffness_coefficient)
        _not_negative("mass_coefficient", self.mass_coefficient)


@dataclass(frozen=True)
class ModalDamping:
    """Loss factors of the elastic modes in rising order; the last one holds for all above."""

    loss_factors: tuple[float, ...]  # eta_r; of a damping ratio zeta: 2 zeta

    def __post_init__(self) -> None:
        if not self.loss_factors:
            raise InvalidInputError("modal damping needs a loss factor", field="loss_factors")
        _not_negative("loss_factors", *self.loss_factors)


Damping = StructuralDamping | ViscousDamping | ModalDamping

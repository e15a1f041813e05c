"""Tolerances of a test: standard deviations of what may differ a little from model and log book."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.optimisation.settings import TOLERANCE


@dataclass(frozen=True)
class Tolerances:
    """One standard deviation each of what may differ a little; 0: exactly as declared."""

    modulus: float = 0.0
    """Relative, of the Young's modulus of all members together."""
    density: float = 0.0
    """Relative, of the density of all members together."""
    sensitivity: float = 0.0
    """Relative, of the sensitivity of each response transducer."""
    accelerometer_mass: float = 0.0
    """Relative, of the mass of the accelerometers."""
    delay: float = 0.0
    """s, delay of each response channel against the force."""
    modal_loss_factor: float = 0.0
    """Relative, of the loss factor of each elastic mode of the model in the band."""

    def __post_init__(self) -> None:
        for field in fields(self):
            delay = field.name == "delay"
            value, limit = getattr(self, field.name), TOLERANCE.max_delay if delay else TOLERANCE.max_relative
            if not 0 <= value <= limit:  # NaN fails too
                raise InvalidInputError(
                    f"the tolerance of the {field.name.replace('_', ' ')} is out of bounds",
                    field=f"tolerances.{field.name}",
                    value=value,
                    allowed=f"0 to {limit:g}" + (" s" if delay else ""),
                )

    @classmethod
    def of(cls, values: Mapping[str, float]) -> "Tolerances":
        """Return the tolerances of plain data.

        Raises
        ------
        InvalidInputError
            If a name is unknown or a value out of bounds.
        """
        names = [field.name for field in fields(cls)]
        for name in values:
            if name not in names:
                raise InvalidInputError(
                    f"nothing that is tolerated is called {name!r}",
                    field="tolerances",
                    value=name,
                    allowed=list(names),
                )
        return cls(**{name: float(value) for name, value in values.items()})


NO_TOLERANCES = Tolerances()

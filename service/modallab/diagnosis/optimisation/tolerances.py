"""Tolerances of a test: standard deviations of what may differ a little from model and log book."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from modallab.core.errors import InvalidInputError
from modallab.core.options import Options, option
from modallab.diagnosis.optimisation.settings import TOLERANCE


def _relative(doc: str) -> Any:
    """Declare a relative standard deviation."""
    return option(0.0, unit="1", lower=0.0, upper=TOLERANCE.max_relative, doc=f"relative, of {doc}")


@dataclass(frozen=True)
class Tolerances(Options):
    """One standard deviation each of what may differ a little; 0: exactly as declared."""

    options_path: ClassVar[str] = "tolerances."

    modulus: float = _relative("the Young's modulus of all members together")
    density: float = _relative("the density of all members together")
    sensitivity: float = _relative("the sensitivity of each response transducer")
    accelerometer_mass: float = _relative("the mass of the accelerometers")
    delay: float = option(
        0.0,
        unit="s",
        lower=0.0,
        upper=TOLERANCE.max_delay,
        doc="delay of each response channel against the force",
    )
    modal_loss_factor: float = _relative("the loss factor of each elastic mode of the model in the band")
    modulus_variation: float = _relative(
        "the Young's modulus of each member, a smooth random field along the structure"
    )
    density_variation: float = _relative("the density of each member, a smooth random field as well")

    @classmethod
    def of(cls, values: Mapping[str, float]) -> "Tolerances":
        """Return the tolerances of plain data.

        Raises
        ------
        InvalidInputError
            If a name is unknown or a value out of bounds.
        """
        for name in values:
            if name not in cls.specs():
                raise InvalidInputError(
                    f"nothing that is tolerated is called {name!r}",
                    field="tolerances",
                    value=name,
                    allowed=list(cls.specs()),
                )
        return cls(**{name: float(value) for name, value in values.items()})


NO_TOLERANCES = Tolerances()

"""Tolerances of a test: standard deviations of what may differ a little from model and log book."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar

from modallab.core.errors import InvalidInputError
from modallab.core.options import Options, option
from modallab.diagnosis.optimisation.settings import PRESET, PRESET_NAMES, TOLERANCE


class TolerancePreset(StrEnum):
    """Names of whole sets of tolerances."""

    NONE = "none"
    CAREFUL = "careful"
    ORDINARY = "ordinary"
    STUDENT = "student"


def _relative(doc: str) -> Any:
    """Declare a relative standard deviation."""
    return option(None, unit="1", lower=0.0, upper=TOLERANCE.max_relative, doc=f"relative, of {doc}")


@dataclass(frozen=True)
class Tolerances(Options):
    """One standard deviation each of what may differ a little; 0: exactly as declared.

    One that is left out is 0 for a simulated test, and assumed as in `ordinary` for an uploaded test that
    the stated ones leave unexplained.
    """

    options_path: ClassVar[str] = "tolerances."

    modulus: float | None = _relative("the Young's modulus of all members together")
    density: float | None = _relative("the density of all members together")
    sensitivity: float | None = _relative("the sensitivity of each response transducer")
    accelerometer_mass: float | None = _relative("the mass of the accelerometers")
    delay: float | None = option(
        None,
        unit="s",
        lower=0.0,
        upper=TOLERANCE.max_delay,
        doc="delay of each response channel against the force",
    )
    modal_loss_factor: float | None = _relative(
        "the loss factor of each elastic mode of the model in the band, on a logarithmic scale"
    )
    modulus_variation: float | None = _relative(
        "the Young's modulus of each member, a smooth random field along the structure"
    )
    density_variation: float | None = _relative("the density of each member, a smooth random field as well")

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

    @classmethod
    def preset(cls, preset: TolerancePreset) -> "Tolerances":
        """Return the tolerances of a preset."""
        if preset is TolerancePreset.NONE:
            return cls(**dict.fromkeys(cls.specs(), 0.0))
        column = PRESET_NAMES.index(preset.value)
        return cls(**{name: getattr(PRESET, name)[column] for name in cls.specs()})

    @property
    def stated(self) -> dict[str, float]:
        """The tolerances that are not left out, by name."""
        values = {name: getattr(self, name) for name in self.specs()}
        return {name: value for name, value in values.items() if value is not None}

    def completed(self, others: "Tolerances") -> "Tolerances":
        """Return the tolerances with those of others in place of what is left out."""
        return Tolerances(**{**others.stated, **self.stated})


NO_TOLERANCES = Tolerances()

"""Wire types of what may differ a little and is no missing effect."""

from typing import Annotated

from pydantic import Field

from modallab.api.wire import NO_CONVERSION, Wire
from modallab.diagnosis.optimisation.settings import TOLERANCE

Relative = Annotated[
    float,
    Field(ge=0, le=TOLERANCE.max_relative, description="one standard deviation, relative"),
    NO_CONVERSION,
]
Late = Annotated[
    float, Field(ge=0, le=TOLERANCE.max_delay, description="one standard deviation, s"), NO_CONVERSION
]


class TolerancesIn(Wire):
    """What may differ a little; what is left out is taken at its word."""

    modulus: Relative = 0.0
    density: Relative = 0.0
    sensitivity: Relative = 0.0
    accelerometer_mass: Relative = 0.0
    delay: Late = 0.0
    modal_loss_factor: Relative = 0.0

    def to_arguments(self) -> dict[str, float]:
        """Return the tolerances that were given."""
        return self.model_dump(exclude_defaults=True)

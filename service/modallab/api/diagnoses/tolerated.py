"""Wire types of what may differ a little and is no missing effect."""

import math
from typing import Annotated, Any

from pydantic import Field

from modallab.api.wire import NO_CONVERSION, Wire, place_out
from modallab.diagnosis.optimisation.tolerances import LATEST, WIDEST
from modallab.diagnosis.result import ToleratedParameter

Relative = Annotated[
    float,
    Field(ge=0, le=WIDEST, description="one standard deviation, relative"),
    NO_CONVERSION,
]
Late = Annotated[float, Field(ge=0, le=LATEST, description="one standard deviation, s"), NO_CONVERSION]


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


def tolerated_out(one: ToleratedParameter) -> dict[str, Any]:
    """Return a number that may differ a little, as it was fitted."""
    error = one.standard_error
    return {
        "name": one.name,
        "at": place_out(one.at),
        "mode": one.mode,
        "value": one.value,
        "standard_error": error if math.isfinite(error) else None,
        "tolerance": one.tolerance,
        "unit": one.unit,
    }

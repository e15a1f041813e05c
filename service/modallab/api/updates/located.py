"""Wire types of what error location by one step finds."""

import math
from typing import Any, Self

from pydantic import BaseModel

from modallab.updating.error_location.method import LOCATED, LocationResult


class LocatedOut(BaseModel):
    """What a method of error location found, by part and member; the model stays as it is.

    `changes`: of coefficients, to first order. `weights`: share of the difference that each stands for.
    `remaining`: share of the difference that 1, 2, ... coefficients leave, where they are added one by one.
    """

    method: str
    changes: dict[str, dict[int, float]]
    weights: dict[str, dict[int, float]]
    remaining: list[float]

    @classmethod
    def of(cls, result: LocationResult) -> Self:
        """Return what the contract shows of error location."""
        return cls(
            method=result.locator,
            changes={part: dict(table) for part, table in result.changes.items()},
            weights={part: dict(table) for part, table in result.weights.items()},
            remaining=result.remaining.tolist(),
        )


def located_fields(result: LocationResult) -> dict[str, Any]:
    """Return the fields of an update's reply; those of corrected models are empty."""
    return {
        "converged": False,
        "stopped_because": LOCATED,
        "iterations": {},
        "coefficients": {},
        "standard_errors": {},
        "suspected": {part: list(found) for part, found in result.suspected.items()},
        "frequencies": {
            "measured": result.measured.tolist(),
            "before": result.frequencies.tolist(),
            "location": None,
            "after": None,
        },
        "mac": {"measured": None, "before": result.mac.tolist(), "location": None, "after": None},
        "rank": result.rank,
        "condition_number": number(result.condition_number),
        "history": [],
        "structure_id": None,
        "located": LocatedOut.of(result),
    }


def number(value: float) -> float | None:
    """Return a number that JSON has, None for one that is not finite."""
    return value if math.isfinite(value) else None

"""Wire types of what data say of coefficients, and do not."""

from collections.abc import Iterable, Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from modallab.api.updates.located import number
from modallab.updating.identifiability import Direction, Identifiability
from modallab.updating.parameterisation import MacroElement
from modallab.updating.quantities import Quantity


class ShareOut(BaseModel):
    """A coefficient's share of a direction; the squares of all add up to one."""

    part: str
    members: list[int]
    share: float


class DirectionOut(BaseModel):
    """Coefficients that may change together, in these shares, with little or nothing of it in the data.

    `standard_error`: of the relative change along it, null where the data say nothing at all.
    """

    words: str
    standard_error: float | None
    shares: list[ShareOut]

    @classmethod
    def of(cls, direction: Direction) -> Self:
        """Return what the contract shows of a direction."""
        shares = [
            ShareOut(part=macro.part, members=list(macro.members), share=float(share))
            for macro, share in zip(direction.macros, direction.shares, strict=True)
        ]
        return cls(words=direction.words, standard_error=direction.standard_error, shares=shares)


class IdentifiabilityOut(BaseModel):
    """How far the data alone determine the coefficients that were free to move.

    `unidentified`: members by part whose relative standard error is larger than the option
    `identified_within`. The covariance is under `covariance`.
    """

    rank: int
    condition_number: float | None
    singular_values: list[float]
    unidentified: dict[str, list[int]]
    directions: list[DirectionOut]

    @classmethod
    def of(cls, found: Identifiability) -> Self:
        """Return what the contract shows of identifiability."""
        return cls(
            rank=found.rank,
            condition_number=number(found.condition_number),
            singular_values=found.singular_values.tolist(),
            unidentified=_by_part(found.unidentified),
            directions=[DirectionOut.of(one) for one in found.directions],
        )


class QuantityOut(BaseModel):
    """A property of some members in its own unit; `interval` holds it with 95 %, by the data alone."""

    part: str
    members: list[int]
    unit: str
    before: float
    after: float
    interval: tuple[float, float] | None

    @classmethod
    def of(cls, found: Quantity) -> Self:
        """Return what the contract shows of a property."""
        return cls(**vars(found) | {"members": list(found.members)})


def identified_arrays(found: Identifiability) -> Mapping[str, NDArray[Any]]:
    """Return the covariance of coefficients and their names, under the names that the API serves."""
    arrays = {
        "coefficients": np.array([str(macro) for macro in found.macros]),
        "intervals": found.intervals,
        "singular_values": found.singular_values,
    }
    return arrays if found.covariance is None else arrays | {"covariance": found.covariance}


def _by_part(macros: Iterable[MacroElement]) -> dict[str, list[int]]:
    table: dict[str, list[int]] = {}
    for macro in macros:
        table.setdefault(macro.part.value, []).extend(macro.members)
    return {part: sorted(members) for part, members in table.items()}

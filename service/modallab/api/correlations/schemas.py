"""Request of a correlation."""

from modallab.api.deps import Id
from modallab.api.limits import REQUEST
from modallab.api.reductions import Reduced
from modallab.api.wire import ModeCount, Wire
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet


class CorrelationIn(Wire):
    """Measured modes against the first `count` elastic modes of a structure, as many by default.

    `reduction` adds orthogonality in the structure's mass, reduced to the common DoFs; `measurement_id`
    the measured FRFs against the structure's.
    """

    modal_model_id: Id
    """id of the measured modes"""
    structure_id: Id
    """id of the structure"""
    count: ModeCount | None = None
    """elastic modes of the structure; left out: as many as were measured"""
    reduction: Reduced | None = None
    """reduction of the mass matrix to the measured degrees of freedom; null: no orthogonality"""
    measurement_id: Id | None = None
    """id of a measurement whose FRFs are compared too"""

    @property
    def inputs(self) -> dict[str, str]:
        """Ids of the correlated resources by role."""
        ids = {"modal_model_id": self.modal_model_id, "structure_id": self.structure_id}
        return ids if self.measurement_id is None else ids | {"measurement_id": self.measurement_id}


def small(frf: FrfSet) -> FrfSet:
    """Return FRFs as they are; `InvalidInputError` if they are too many to wait for."""
    if frf.values.size > REQUEST.correlation_values:
        raise InvalidInputError(
            "too many lines and FRFs to wait for",
            field="measurement_id",
            value=frf.values.size,
            allowed=bounds(maximum=REQUEST.correlation_values, unit="lines x FRFs"),
        )
    return frf

"""Request of a correlation."""

from pydantic import ConfigDict

from modallab.api.deps import Id
from modallab.api.derived import body_of, options_from
from modallab.api.limits import REQUEST
from modallab.api.reductions import Reduced
from modallab.api.wire import ModeCount
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.core.line_options import LineOptions, line_mask


class CorrelationIn(body_of(LineOptions)):  # type: ignore[misc]
    """Measured modes against the first `count` elastic modes of a structure, as many by default.

    `reduction` adds orthogonality in the structure's mass, reduced to the common DoFs; `measurement_id`
    the measured FRFs against the structure's, at the lines that `bands` and `exclude` leave.
    """

    model_config = ConfigDict(use_attribute_docstrings=True)

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

    def lines_of(self, frf: FrfSet) -> FrfSet:
        """Return measured FRFs at the lines that count; `InvalidInputError` where a band is none of them."""
        options = options_from(LineOptions, self)
        return small(frf.at(line_mask(frf.freq, options.bands, options.exclude)))


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

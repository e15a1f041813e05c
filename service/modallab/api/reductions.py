"""Wire types of reductions: by name, or by name with numbers; and a reduced model's arrays."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from pydantic import Field

from modallab.api.limits import REPLY, REQUEST
from modallab.api.names import ReductionKind
from modallab.api.schema import NamedByPattern
from modallab.api.wire import DofText, Number, Text, Wanted, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.correlation.orthogonality import frequency_errors
from modallab.fe.reduction import Reduction, reduce, reduction_of
from modallab.fe.synthetic_modes import exact_modes, lowest_modes
from modallab.fe.system import DynamicSystem


class ReductionIn(Wire):
    """A reduction with its numbers, as `/catalog/reductions` lists them."""

    kind: ReductionKind
    """name of the reduction"""
    parameters: Annotated[dict[Text, Number], NamedByPattern()] = Field(default_factory=dict, max_length=20)
    """numbers of the reduction by name"""


Reduced = Annotated[ReductionKind | ReductionIn, Field(description="a kind, or a kind with its parameters")]


def reduction_in(parameters: str | ReductionIn) -> Reduction:
    """Return the reduction that was asked for, its kind, parameters and bounds checked."""
    return (
        reduction_of(parameters)
        if isinstance(parameters, str)
        else reduction_of(parameters.kind, parameters.parameters)
    )


def check_size(system: DynamicSystem, n_masters: int, field: str) -> None:
    """Raise `InvalidInputError` if a transformation is too large to wait for."""
    size = len(system.dofs) * n_masters
    if size > REQUEST.transformation_values:
        raise InvalidInputError(
            "too large a transformation to wait for",
            field=field,
            value=size,
            allowed=bounds(maximum=REQUEST.transformation_values, unit="degrees of freedom x masters"),
        )


class ReducedWanted(Wanted):
    """The DoFs that are kept, and how the others follow them."""

    masters: list[DofText] = Field(min_length=1, max_length=1_000)
    """master degrees of freedom"""
    kind: ReductionKind = "guyan"
    """name of the reduction"""
    frequency: float | None = Field(None, description="Hz, of `dynamic`")
    iterations: float | None = Field(None, description="of `irs`")
    modes: float | None = Field(None, description="elastic modes, of `serep`")

    def arrays(self, system: DynamicSystem) -> Mapping[str, NDArray[Any]]:
        """Return the reduced matrices, the transformation, and how near the reduced modes come.

        Raises
        ------
        InvalidInputError
            If this is too much to wait for, or the masters do not determine the motion of the others.
        UnknownDofError
            If the structure has no such DoF.
        """
        check_size(system, len(self.masters), "masters")
        numbers = {name: getattr(self, name) for name in ("frequency", "iterations", "modes")}
        parameters = {name: value for name, value in numbers.items() if value is not None}
        masters = tuple(Dof.parse(text, field="masters") for text in self.masters)
        reduced = reduce(system, masters, reduction_of(self.kind, parameters))
        frequencies, shapes = reduced.modes()
        _, n_rigid_body = lowest_modes(system, 1)
        full = exact_modes(system, max(1, min(REPLY.reduced_modes, len(frequencies) - n_rigid_body)))
        shapes_at_masters = full.shapes[[system.index(dof) for dof in masters]]
        return {
            "masters": np.array([str(dof) for dof in reduced.masters]),
            "dofs": np.array([str(dof) for dof in reduced.dofs]),
            "transformation": reduced.transformation,
            "mass": reduced.mass,
            "stiffness": reduced.stiffness,
            "frequencies": frequencies,
            "shapes": shapes,
            "model_frequencies": full.frequencies,
            "frequency_errors": frequency_errors(reduced, shapes_at_masters, full.frequencies),
        }


ReducedQuery = Annotated[ReducedWanted, Query()]

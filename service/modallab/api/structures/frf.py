"""Request for the exact FRFs of a structure, with limits on its size."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from pydantic import Field

from modallab.api.limits import REQUEST
from modallab.api.schema import Limits
from modallab.api.wire import DofText, Wanted
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.fe.structure import Structure
from modallab.rig.exact import exact_frf


class FrfWanted(Wanted):
    """A drive point, responses, lines, and the kind of FRF."""

    drive: DofText
    """degree of freedom of the force"""
    responses: list[DofText] = Field(min_length=1, max_length=1_000)
    """degrees of freedom of the responses"""
    kind: FrfKind = Field(FrfKind.INERTANCE, description="receptance and mobility leave the line at 0 Hz out")
    frequency_max: Annotated[float, Limits(1e-3, 1e6)] = Field(
        800.0, description="Hz, of the last line; the first is at 0 Hz"
    )
    n_lines: Annotated[int, Limits(8, 20001)] = Field(401, description="number of lines, 0 Hz counted")

    def arrays(self, structure: Structure) -> Mapping[str, NDArray[Any]]:
        """Return `freq, values, outputs, inputs, kind, notes`, as of a measurement.

        Raises
        ------
        InvalidInputError
            If this is too much to wait for, or out of bounds.
        UnknownDofError
            If the structure has no such DoF.
        """
        self._check_small(structure)
        frf = exact_frf(
            structure,
            Dof.parse(self.drive, field="drive"),
            [Dof.parse(text, field="responses") for text in self.responses],
            frequency_max=self.frequency_max,
            n_lines=self.n_lines,
        )
        notes = frf.left_out(self.kind)
        if notes:
            frf = frf.between(0.0, np.inf)
        return {
            "freq": frf.freq,
            "values": frf.to(self.kind).values,
            "outputs": np.array([str(dof) for dof in frf.outputs]),
            "inputs": np.array([str(dof) for dof in frf.inputs]),
            "kind": np.array(self.kind.value),
            "notes": np.array(notes, dtype=str),
        }

    def _check_small(self, structure: Structure) -> None:
        size = self.n_lines * len(self.responses)
        if size > REQUEST.structure_frf_values:
            raise InvalidInputError(
                "too many numbers to wait for: measure them by the expected route on an ideal rig",
                field="n_lines",
                value=size,
                allowed=bounds(maximum=REQUEST.structure_frf_values, unit="lines x responses"),
            )
        if len(structure.dofs) > REQUEST.structure_frf_dofs:
            raise InvalidInputError(
                "too large a structure to wait for: measure it by the expected route on an ideal rig",
                field="structure_id",
                value=len(structure.dofs),
                allowed=bounds(maximum=REQUEST.structure_frf_dofs, unit="degrees of freedom"),
            )


FrfQuery = Annotated[FrfWanted, Query()]

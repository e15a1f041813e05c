"""Wire types of what direct methods find."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from modallab.core.arrays import FloatArray
from modallab.updating.direct.result import DirectResult, OtherModes


class DofErrorOut(BaseModel):
    """How far a matrix is off at a degree of freedom, relative."""

    dof: str
    error: float


class OtherModesOut(BaseModel):
    """Elastic modes of the model that no measured one was used for, Hz.

    `rigid_body`: highest at which a motion that was free is held now; null where none was free. Below zero a
    frequency stands for a stiffness that pushes away.
    """

    before: list[float]
    after: list[float]
    mac: list[float]
    rigid_body: float | None

    @classmethod
    def of(cls, modes: OtherModes) -> Self:
        """Return what the contract shows of other modes."""
        return cls(
            before=modes.before.tolist(),
            after=modes.after.tolist(),
            mac=modes.mac.tolist(),
            rigid_body=modes.rigid_body,
        )


class DirectOut(BaseModel):
    """What a direct method found; its matrices are under `arrays`.

    `n_modes`: measured modes that were used, the first of `frequencies` and `mac`. `dof_errors`: by matrix,
    the largest first. `connectivity_loss`: by matrix, the share of the correction that connects what the
    structure does not.
    """

    method: str
    completion: str
    n_dofs: int
    n_modes: int
    reproduced: float | None
    connectivity_loss: dict[str, float]
    other_modes: OtherModesOut | None
    dof_errors: dict[str, list[DofErrorOut]]
    notes: list[str]

    @classmethod
    def of(cls, result: DirectResult) -> Self:
        """Return what the contract shows of a direct method."""
        return cls(
            method=result.method,
            completion=result.completion,
            n_dofs=len(result.dofs),
            n_modes=result.modes.n_used,
            reproduced=result.reproduced,
            connectivity_loss=dict(result.connectivity_loss),
            other_modes=None if result.other_modes is None else OtherModesOut.of(result.other_modes),
            dof_errors={matrix: _ranked(result, matrix) for matrix in result.dof_errors},
            notes=list(result.notes),
        )


def _ranked(result: DirectResult, matrix: str) -> list[DofErrorOut]:
    errors = dict(zip(result.dofs, result.dof_errors[matrix].tolist(), strict=True))
    return [DofErrorOut(dof=str(dof), error=errors[dof]) for dof in result.ranked(matrix)]


def direct_fields(result: DirectResult) -> dict[str, Any]:
    """Return the fields of an update's reply; coefficients only of a method that keeps the members."""
    modes = result.modes
    if result.corrects:
        ended = "solved at once, without iteration"
        if not result.converged:
            ended = f"{ended}; measured shapes or frequencies are missed by {result.reproduced:.2g}"
    else:
        ended = "errors are located, nothing is corrected"
    return {
        "converged": result.converged,
        "stopped_because": ended,
        "iterations": {},
        "coefficients": {part: dict(table) for part, table in result.coefficients.items()},
        "standard_errors": {},
        "suspected": {},
        "frequencies": {
            "measured": modes.measured.tolist(),
            "before": modes.before.tolist(),
            "location": None,
            "after": _list(modes.after),
        },
        "mac": {
            "measured": None,
            "before": modes.mac_before.tolist(),
            "location": None,
            "after": _list(modes.mac_after),
        },
        "rank": None,
        "condition_number": None,
        "history": [],
        "structure_id": None,
        "direct": DirectOut.of(result),
    }


def direct_arrays(result: DirectResult) -> Mapping[str, NDArray[Any]]:
    """Return updated matrices, and errors by matrix, under the names that the API serves."""
    updated = {"mass": result.mass, "stiffness": result.stiffness}
    arrays: dict[str, NDArray[Any]] = {"dofs": np.array([str(dof) for dof in result.dofs])}
    arrays |= {name: matrix for name, matrix in updated.items() if matrix is not None}
    for name, matrix in result.errors.items():
        arrays[name if name == "force_balance" else f"{name}_error"] = matrix
    return arrays


def _list(values: FloatArray | None) -> list[float] | None:
    return None if values is None else values.tolist()

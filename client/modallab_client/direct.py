"""What direct updating methods find: corrected matrices, or where matrices are wrong."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab_client.models import FloatArray


@dataclass(frozen=True, eq=False)
class OtherModes:
    """Elastic modes of the model that no measured one was used for, before and after."""

    before: FloatArray  # (k,) Hz
    after: FloatArray  # (k,) Hz; below zero: a stiffness that pushes away
    mac: FloatArray  # (k,)
    rigid_body: float | None  # Hz, at which motions that were free are held; None where there were none


@dataclass(frozen=True, eq=False)
class DirectFindings:
    """What a direct method found, and what it cost."""

    method: str
    completion: str  # how model and shapes came to the same DoFs
    n_dofs: int
    n_modes: int  # measured modes that were used, the lowest
    reproduced: (
        float | None
    )  # largest error of a used frequency, or 1 - MAC; None where nothing was corrected
    connectivity_loss: Mapping[str, float]  # by matrix: share that connects what the structure does not
    other_modes: OtherModes | None
    dof_errors: Mapping[str, Mapping[str, float]]  # matrix -> DoF -> relative error, the largest first
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class UpdatedMatrices:
    """Matrices of a direct method; None for what it does not have."""

    dofs: tuple[str, ...]
    mass: FloatArray | None  # (n, n) kg, updated
    stiffness: FloatArray | None  # (n, n) N/m
    mass_error: FloatArray | None  # (n, n) what was added, or is estimated to be wrong
    stiffness_error: FloatArray | None
    force_balance: FloatArray | None  # (n, n) forces that are left over

"""What methods find that do not iterate: corrected matrices, or where a model is wrong."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab_client.models import FloatArray


@dataclass(frozen=True, eq=False)
class OtherModes:
    """Elastic modes of the model that no measured one was used for, before and after."""

    before: FloatArray  # (k,) Hz
    after: FloatArray  # (k,) Hz; below zero: a stiffness that pushes away
    mac: FloatArray  # (k,)
    rigid_body: float | None  # Hz, highest at which a motion that was free is held; None where none was


@dataclass(frozen=True, eq=False)
class DirectFindings:
    """What a direct method found, and what it cost."""

    method: str
    completion: str  # how model and shapes came to the same DoFs
    n_dofs: int
    n_modes: int  # measured modes that were used, the lowest
    reproduced: float | None  # largest error of a used frequency, or 1 - MAC; None: nothing was corrected
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


@dataclass(frozen=True, eq=False)
class Suspects:
    """What a method found that locates errors by one step; `suspected` of the update names the members."""

    method: str
    changes: Mapping[str, Mapping[int, float]]  # part -> member -> change of its coefficient, to first order
    weights: Mapping[str, Mapping[int, float]]  # share of the difference that each stands for
    remaining: FloatArray  # (k,) share that 1, 2, ... coefficients leave, where they are added one by one

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Return part, member, change and weight of every coefficient that has a change, as text."""
        return [
            (part, str(member), f"{change:.4g}", f"{self.weights[part][member]:.3g}")
            for part, members in self.changes.items()
            for member, change in members.items()
            if change
        ]

"""Suspension of the structure as declared."""

from dataclasses import dataclass

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.rig.hardware import within


@dataclass(frozen=True)
class Suspension:
    """Identical elastic bands; without any the structure is free."""

    at: tuple[Dof, ...] = ()
    """DoFs at which bands hold the structure."""
    stiffness: float = 0.0
    """N/m, of each band."""
    loss_factor: float = 0.0
    """1, hysteretic loss factor of each band."""

    def __post_init__(self) -> None:
        within("suspension.stiffness", self.stiffness, 0.0, 1e9)
        within("suspension.loss_factor", self.loss_factor, 0.0, 1.0)
        for dof in self.at:
            if not dof.translational:
                raise InvalidInputError(
                    f"{dof} is a rotation: a band pulls along X, Y or Z",
                    field="suspension.at",
                    value=str(dof),
                    allowed=["X", "Y", "Z"],
                )
        if len({dof.point for dof in self.at}) < len(self.at):
            raise InvalidInputError("a band is named twice", field="suspension.at")

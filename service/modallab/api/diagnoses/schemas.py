"""Wire types of diagnoses."""

from typing import Annotated, Any, Literal

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.diagnoses.follow_ups import FollowUpIn
from modallab.api.diagnoses.tolerated import TolerancesIn
from modallab.api.wire import NO_CONVERSION, DofText, NoiseFloor, Number, Seed, Text, Wire
from modallab.core.dof import Dof
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS

MOST_FOLLOW_UPS = 8  # each takes as long as the first
Kinds = Annotated[list[Text], Field(min_length=1, max_length=100)]


class HoldOutIn(Wire):
    """FRFs kept out of every fit; responses that were not measured are predicted."""

    fraction: Number = 0.25
    dofs: list[DofText] = Field(default=[], max_length=200)


class DiagnosisStart(Wire):
    """A model and a measurement that part; `act` runs the proposed next tests where the rig is ours."""

    structure_id: Id
    measurement_id: Id
    suspects: Literal["all"] | Kinds = "all"
    hold_out: HoldOutIn = HoldOutIn()
    tolerances: TolerancesIn = TolerancesIn()
    follow_ups: list[FollowUpIn] = Field(default=[], max_length=MOST_FOLLOW_UPS)
    act: bool = False
    noise_floor: NoiseFloor | None = Field(
        default=None,
        description="relative random error of every FRF, of its median where it is below that; beside what "
        "coherence and averages tell, alone where there is no coherence",
    )
    max_effects: Annotated[int, Field(ge=1, le=8), NO_CONVERSION] = 4
    seed: Seed = 0

    def to_arguments(self, structure: Structure) -> dict[str, Any]:
        """Return the task's arguments, checked as far as can be before the work.

        Raises
        ------
        InvalidInputError
            If a suspect is unknown.
        UnknownDofError
            If the structure lacks a DoF to hold out.
        """
        kinds = None if self.suspects == "all" else list(self.suspects)
        for kind in kinds or ():
            EFFECTS[kind]
        for text in self.hold_out.dofs:
            structure.index(Dof.parse(text, field="hold_out.dofs"))
        return {
            "structure_id": self.structure_id,
            "measurement_id": self.measurement_id,
            "suspects": kinds,
            "hold_out_fraction": self.hold_out.fraction,
            "hold_out": list(self.hold_out.dofs),
            "tolerances": self.tolerances.to_arguments(),
            "max_effects": self.max_effects,
            "seed": self.seed,
            "follow_ups": [one.to_arguments() for one in self.follow_ups],
            "act": self.act,
            "noise_floor": self.noise_floor,
        }

"""Wire types of diagnoses."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.diagnoses.follow_ups import FollowUpIn
from modallab.api.diagnoses.located import located_out
from modallab.api.diagnoses.tolerated import TolerancesIn, tolerated_out
from modallab.api.wire import (
    NO_CONVERSION,
    DofText,
    EntryOut,
    NoiseFloor,
    Number,
    Seed,
    Text,
    Wire,
    place_out,
)
from modallab.core.dof import Dof
from modallab.diagnosis.result import Diagnosis, EquivalentEffect, FittedEffect, NextTest, Rival, Step
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS
from modallab.store.base import Entry

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


class DiagnosisOut(EntryOut):
    """Where model and measurement part, what was missing, how sure, what is left."""

    verdict: str
    located: dict[str, Any]
    steps: list[dict[str, Any]]
    remaining_gap: float | None
    remaining_scatter: float | None
    gaps: dict[str, dict[str, float | None]]
    tolerated: list[dict[str, Any]]
    next_test: dict[str, Any] | None
    follow_ups: list[dict[str, Any]]
    notes: list[str]
    structure_id: str
    rig_id: str

    @classmethod
    def of(cls, found: Diagnosis, entry: Entry) -> Self:
        """Return what the contract shows of a diagnosis."""
        return cls(
            **cls.fields(entry),
            verdict=found.verdict.value,
            located=located_out(found.located),
            steps=[_step(step) for step in found.steps],
            remaining_gap=_number(found.remaining_gap),
            remaining_scatter=_number(found.remaining_scatter),
            gaps={when: _numbers(parts) for when, parts in found.gaps.items()},
            tolerated=[tolerated_out(one) for one in found.tolerated],
            next_test=None if found.next_test is None else _next_test(found.next_test),
            follow_ups=[
                {"measurement_id": entry.inputs[f"follow_up_{i}"], "changed": dict(changed)}
                for i, changed in enumerate(found.follow_ups, 1)
            ],
            notes=list(found.notes),
            structure_id=entry.inputs["extended_structure_id"],
            rig_id=entry.inputs["extended_rig_id"],
        )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _numbers(values: Mapping[str, float]) -> dict[str, float | None]:
    return {name: _number(value) for name, value in values.items()}


def _step(step: Step) -> dict[str, Any]:
    gaps = ("gap_before", "gap_after", "held_out_gap_before", "held_out_gap_after", "held_out_scatter")
    return {
        "effect": _effect(step.effect),
        "probability": _number(step.probability),
        **{name: _number(getattr(step, name)) for name in gaps},
        "rivals": [_rival(rival) for rival in step.rivals],
        "rivals_alike": [_alias(alias) for alias in step.rivals_alike],
    }


def _effect(effect: FittedEffect) -> dict[str, Any]:
    parameters = {
        name: {"value": one.value, "standard_error": _number(one.standard_error), "unit": one.unit}
        for name, one in effect.parameters.items()
    }
    return {"kind": effect.kind, "at": place_out(effect.at), "parameters": parameters}


def _alias(alias: EquivalentEffect | Rival) -> dict[str, Any]:
    return {"kind": alias.kind, "at": place_out(alias.at)}


def _rival(rival: Rival) -> dict[str, Any]:
    numbers = {"probability": _number(rival.probability), "gap_after": _number(rival.gap_after)}
    return _alias(rival) | numbers


def _next_test(test: NextTest) -> dict[str, Any]:
    return {
        "why": test.why,
        "change": dict(test.change),
        "separates": list(test.separates),
        "expected_separation": _number(test.expected_separation),
    }

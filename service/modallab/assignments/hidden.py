"""Hidden effects: fixed, or templates from which each student's are drawn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from modallab.assignments.drawing import Lot
from modallab.core.place import EffectSpec, Place


@dataclass(frozen=True)
class HiddenEffect:
    """An effect that a test has and its log book does not tell."""

    kind: str
    """Name of the effect in the catalogue."""
    places: tuple[Place, ...] = (None,)
    """Places, one of which is drawn; a single one is fixed."""
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """SI units, lower and upper limit of each parameter; a fixed one has equal limits."""

    def effect_for(self, lot: Lot) -> EffectSpec:
        """Return the effect of one student."""
        place = self.places[int(lot.fraction() * len(self.places))]
        values = {
            name: lower if lower == upper else lower + (upper - lower) * lot.fraction(index)
            for index, (name, (lower, upper)) in enumerate(sorted(self.intervals.items()), start=1)
        }
        return EffectSpec(self.kind, place, values)

    def extremes(self) -> list[EffectSpec]:
        """Return the effect at every place with the limits of all parameters, lower ones and upper ones."""
        ends = [{name: limits[end] for name, limits in self.intervals.items()} for end in (0, 1)]
        return [EffectSpec(self.kind, place, values) for place, values in product(self.places, ends)]


def drawn_for(hidden: Sequence[HiddenEffect], secret: str, student: str) -> tuple[EffectSpec, ...]:
    """Return the effects of one student, the same at every call.

    Parameters
    ----------
    secret
        Of the assignment.
    student
        Id of the student's key.
    """
    return tuple(
        effect.effect_for(Lot(secret, f"effect/{student}/{number}")) for number, effect in enumerate(hidden)
    )

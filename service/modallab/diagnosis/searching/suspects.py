"""Effects that may be missing, and those of them that the evidence supports."""

from collections.abc import Sequence
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.rig.effect import EFFECTS, Effect


@dataclass(frozen=True)
class Suspects:
    """Effects that may be missing, one for every kind and place."""

    effects: Sequence[Effect]
    """The effects."""
    least: float = 0.0
    """Suspicion below which a kind is not considered, 0 to 1."""

    def of(self, predictor: Predictor, accepted: Sequence[Effect]) -> list[Effect]:
        """Return the effects that the evidence beside accepted effects supports, the likeliest first."""
        # Evidence at one level or drive point may be absent at the others.
        evidence_by_test = [collect_evidence(test, accepted) for test in predictor.tests]
        kinds = {type(effect) for effect in self.effects}
        suspicion = {cls: max(cls.signature(evidence) for evidence in evidence_by_test) for cls in kinds}
        names = {kind_and_place(effect) for effect in accepted}
        effects = [
            effect
            for effect in self.effects
            if suspicion[type(effect)] >= self.least and kind_and_place(effect) not in names
        ]
        return sorted(effects, key=lambda effect: -suspicion[type(effect)])


def suspected(predictor: Predictor, kinds: Sequence[str] | None) -> list[Effect]:
    """Return one effect for each kind and place that may be missing.

    Parameters
    ----------
    kinds
        Kinds of effects; None for all but those that only the user can suspect.

    Raises
    ------
    InvalidInputError
        If a kind is unknown or none is left.
    """
    defaults = [kind for kind, cls in EFFECTS.items() if cls.suspected]
    chosen = defaults if kinds is None else list(dict.fromkeys(kinds))
    free_damping = predictor.nuisances.damping_free
    suspects = [
        EFFECTS[kind](at=place)
        for kind in chosen
        if not (free_damping and EFFECTS[kind].of_stated_damping)
        for place in EFFECTS[kind].places(predictor.system, predictor.setup)
    ]
    if not suspects:
        raise InvalidInputError("no suspect is left", field="suspects", allowed=list(EFFECTS))
    return suspects

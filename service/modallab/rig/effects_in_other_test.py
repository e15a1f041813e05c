"""Transfer of effects from one test to another of the same structure."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.rig.effect import Effect, Stage
from modallab.rig.setup import RigSetup

_CONTACT_STAGES = (Stage.STRUCTURE, Stage.DRIVE)  # stages of what stands between a shaker and the structure


def effects_in_other_test(effects: Sequence[Effect], first: RigSetup, second: RigSetup) -> list[Effect]:
    """Return the effects of the first test that persist in the second, at their places there.

    Effects at the drive point follow the shaker and vanish with it. Effects of a channel or an accelerometer
    persist if the second test measures that DoF. Effects of the structure persist.
    """
    transferred = (_transferred(effect, first, second) for effect in effects)
    return [effect for effect in transferred if effect is not None]


def _transferred(effect: Effect, first: RigSetup, second: RigSetup) -> Effect | None:
    if effect.structural:
        return effect
    measured_points = {dof.point for dof in second.responses}
    if isinstance(effect.at, Channels):
        return effect if all(dof.point in measured_points for dof in effect.at.dofs) else None
    if effect.at_drive:
        # Another exciter has its own force gauge.
        belongs_to_exciter = effect.stage in _CONTACT_STAGES or isinstance(effect.at, Dof)
        return (
            None
            if belongs_to_exciter and second.exciter.kind != first.exciter.kind
            else _at_second_drive(effect, first, second)
        )
    if isinstance(effect.at, Dof) and Dof in effect.allowed_places and type(None) in effect.allowed_places:
        return effect if effect.at.point in measured_points else None  # it sits under one accelerometer
    return effect


def _at_second_drive(effect: Effect, first: RigSetup, second: RigSetup) -> Effect:
    """Return an effect of a drive point, moved to the second test's drive point."""
    first_points = [dof.point for dof in first.drives]
    if (
        not isinstance(effect.at, Dof)
        or effect.at.point not in first_points
        or len(first_points) != len(second.drives)
    ):
        return effect
    return replace(effect, at=second.drives[first_points.index(effect.at.point)].point)

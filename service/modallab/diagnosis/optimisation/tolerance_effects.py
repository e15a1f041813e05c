"""Effects of tolerances that no catalogue has: of accelerometer mass, members, modal loss factors."""

from dataclasses import dataclass, replace
from typing import ClassVar

from modallab.core.parameters import parameter
from modallab.fe.attachment import Attachment
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.point_translations import add_point_masses
from modallab.fe.settings import CACHE
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect, Stage
from modallab.rig.setup import AcquisitionRun

MASS_SUMS: CacheSlot[Attachment] = CacheSlot("sums of masses", CACHE.attachments)


@dataclass(frozen=True)
class AccelerometerTolerance(Effect):
    """Deviation of the accelerometers' mass from the declared one.

    The mass is changed where it is attached already, which adds no DoF to the Woodbury identity.
    """

    kind: ClassVar[str] = "accelerometer_tolerance"
    summary: ClassVar[str] = "accelerometers a little heavier or lighter than declared"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    more: float = parameter(0.0, unit="kg", lower=-0.5, upper=0.5, doc="mass beyond the one declared")

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        """Return the system with the further mass at every accelerometer."""
        points = acquisition_run.accelerometer_points
        masses = add_point_masses(system, points, self.more).attachments[len(system.attachments) :]
        attachments = list(system.attachments)
        places = {a.columns.tobytes(): i for i, a in reversed(list(enumerate(attachments))) if _is_mass(a)}
        for mass in masses:
            place = places.get(mass.columns.tobytes())
            if place is None:
                attachments.append(mass)
            else:
                attachments[place] = _cached_sum(system.dof_cache, attachments[place], mass)
        return replace(system, attachments=tuple(attachments))


def _is_mass(attachment: Attachment) -> bool:
    forces = (attachment.stiffness, attachment.damping, attachment.viscous)
    return attachment.mass is not None and attachment.inner == 0 and all(f is None for f in forces)


def _cached_sum(cache: Cache, first: Attachment, second: Attachment) -> Attachment:
    return cache.compute(MASS_SUMS, (first.key, second.key), lambda: _sum_of_masses(first, second))


def _sum_of_masses(first: Attachment, second: Attachment) -> Attachment:
    """Return one attachment with the masses of two in the same place."""
    assert first.mass is not None
    assert second.mass is not None
    return replace(first, mass=first.mass + second.mass)


@dataclass(frozen=True)
class MemberTolerance(Effect):
    """Deviations of the members' stiffness and mass from the modelled ones, member by member."""

    kind: ClassVar[str] = "member_tolerance"
    summary: ClassVar[str] = "members a little stiffer or heavier than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    tolerance: ClassVar[str | None] = "modulus_variation"
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    stiffness: tuple[float, ...] = ()
    """Factor of each member's stiffness; empty for 1."""
    mass: tuple[float, ...] = ()
    """Factor of each member's mass; empty for 1."""

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        """Return the system with the factors."""
        return system.with_member_factors(stiffness=self.stiffness, mass=self.mass)


@dataclass(frozen=True)
class LossTolerance(Effect):
    """Deviation of the elastic modes' loss factors from the modelled ones, mode by mode.

    D' = D + sum (eta'_r - eta_r) lambda_r (M phi_r)(M phi_r)^T, of the modes of the model alone.
    """

    kind: ClassVar[str] = "loss_tolerance"
    summary: ClassVar[str] = "modes lose a little more or less than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    tolerance: ClassVar[str | None] = "modal_loss_factor"
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    more: tuple[float, ...] = ()
    """Loss factors beyond the model's, of the lowest elastic modes."""

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        """Return the system with further modal loss factors."""
        return system.with_modal_loss(self.more)

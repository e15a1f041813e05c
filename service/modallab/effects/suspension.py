"""Elastic suspension of the structure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.attachment import Attachment
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("suspension")
@dataclass(frozen=True)
class SuspensionStiffness(Effect):
    """Soft spring to the ground with hysteretic loss, k (1 + i eta), one for each elastic band of the rig.

    Rigid-body modes have frequencies above 0 Hz: a body of mass M on two bands bounces at
    omega = sqrt(2 k / M). A structure counts as free if these are below a tenth of the first elastic
    frequency. Ewins, Modal Testing (2000), chapter 3.
    """

    kind: ClassVar[str] = "suspension"
    summary: ClassVar[str] = "elastic band on a nominally free structure"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    same_in_all_runs: ClassVar[bool] = True
    nested_kind: ClassVar[str | None] = "ground_spring"
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    stiffness: float = parameter(100.0, unit="N/m", lower=0.0, upper=1e9, doc="of the band")
    loss_factor: float = parameter(
        0.05, unit="1", lower=0.0, upper=1.0, absent=None, doc="of the band, hysteretic"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        spring = np.array([[self.stiffness]])
        return system.attach(
            Attachment(system.selection((self.at,)), stiffness=spring, damping=self.loss_factor * spring)
        )

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless the band pulls at a translation of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Dof) and not self.at.translational:
            raise self._misplaced("a translation")

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        bands = setup.suspension
        if bands.stiffness == 0:
            return []
        return [cls(at=dof, stiffness=bands.stiffness, loss_factor=bands.loss_factor) for dof in bands.at]

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of a structure that is free to move; none of one that is held."""
        free = system.rigid is not None and system.rigid.shape[1] > 0
        return tuple(dof for dof in system.dofs if dof.translational) if free else ()

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Residuals lie below the first elastic mode."""
        below_first_mode = evidence.freq < 0.5 * evidence.mode_frequency.min(initial=np.inf)
        line = evidence.by_line
        return (
            0.1 + 0.6 * float(line[below_first_mode].sum() / max(line.sum(), 1e-300))
            if below_first_mode.any()
            else 0.1
        )

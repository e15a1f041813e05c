"""Elastic suspension of the structure."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.spatial import KDTree

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Dofs, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import SUSPENSION
from modallab.fe.attachment import Attachment
from modallab.fe.member_table import MemberTable
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("suspension")
@dataclass(frozen=True)
class SuspensionStiffness(Effect):
    """Soft spring to the ground with hysteretic loss, k (1 + i eta), at a DoF, or equal ones at several.

    One for each elastic band of the rig. A diagnosis looks for a single band at each translation, and in a
    plane frame for two equal bands in mirror-image positions about the centre of mass, which then carry
    equal weight.

    Rigid-body modes have frequencies above 0 Hz: a body of mass M on two bands bounces at
    omega = sqrt(2 k / M). A structure counts as free if these are below a tenth of the first elastic
    frequency. Ewins, Modal Testing (2000), chapter 3.
    """

    kind: ClassVar[str] = "suspension"
    summary: ClassVar[str] = "elastic bands on a nominally free structure"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    same_in_all_runs: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("ground_spring",)
    nested_kind: ClassVar[str | None] = "ground_spring"
    allowed_places: ClassVar[tuple[type, ...]] = (Dof, Dofs)
    stiffness: float = parameter(100.0, unit="N/m", lower=0.0, upper=1e9, doc="of each band")
    loss_factor: float = parameter(
        0.05, unit="1", lower=0.0, upper=1.0, absent=None, doc="of each band, hysteretic"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        spring = self.stiffness * np.eye(len(self._dofs))
        return system.attach(
            Attachment(system.selection(self._dofs), stiffness=spring, damping=self.loss_factor * spring)
        )

    @property
    def _dofs(self) -> tuple[Dof, ...]:
        if isinstance(self.at, Dofs):
            return self.at.dofs
        assert isinstance(self.at, Dof)
        return (self.at,)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless the bands pull at translations of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if not all(dof.translational for dof in self._dofs):
            raise self._misplaced("a translation")

    def reduced_model(self) -> tuple[Effect, tuple[str, ...]] | None:
        """Return a spring to the ground for a single band; see `Effect.reduced_model`."""
        return super().reduced_model() if isinstance(self.at, Dof) else None

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        bands = setup.suspension
        if bands.stiffness == 0:
            return []
        return [cls(at=dof, stiffness=bands.stiffness, loss_factor=bands.loss_factor) for dof in bands.at]

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of a structure that is free to move, and every pair of equal bands.

        None of a structure that is held.
        """
        if system.rigid is None or system.rigid.shape[1] == 0:
            return ()
        translations = [dof for dof in system.dofs if dof.translational]
        pairs = [] if system.members is None else _balanced_pairs(system.members, translations)
        return (*translations, *pairs)

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


def _balanced_pairs(members: MemberTable, translations: Sequence[Dof]) -> Iterator[Dofs]:
    """Yield the pairs of translations that carry equal weight: mirror images about the centre of mass.

    Parameters
    ----------
    members
        Bars in a plane; other members have no pairs.
    """
    if not members.bars.all():
        return
    position = dict(zip(np.ravel(members.ends).tolist(), members.points.reshape(-1, 2).tolist(), strict=True))
    centre = _centre_of_mass(members)
    tolerance = np.ptp(members.points.reshape(-1, 2), axis=0).max() * SUSPENSION.largest_offset
    for across, direction in enumerate("YX"):  # bands along Y stand at two X, and vice versa
        dofs = [dof for dof in translations if dof.direction == direction and dof.node in position]
        if not dofs:
            continue
        points = np.array([position[dof.node] for dof in dofs])
        images = points.copy()
        images[:, across] = 2 * centre[across] - points[:, across]
        distances, nearest = KDTree(points).query(images)
        for i, (distance, j) in enumerate(zip(distances, nearest, strict=True)):
            if i < j and distance < tolerance:
                yield Dofs((dofs[i], dofs[j]))


def _centre_of_mass(members: MemberTable) -> FloatArray:
    """Return the centre of mass (2,), m, of bars in a plane."""
    along_y = members.mass[:, 1:6:3, 1:6:3].sum(axis=(1, 2))  # kg, mass of each bar in a translation
    return np.asarray(along_y @ members.centres[:, :2] / along_y.sum())

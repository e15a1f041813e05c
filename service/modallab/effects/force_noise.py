"""Noise of the force channel."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup
from modallab.rig.source import NoiseLevels


@EFFECTS.register("force_noise")
@dataclass(frozen=True)
class ForceNoise(Effect):
    """White noise on the force signal; it makes H1 too small where the force has dips.

    H1 = H / (1 + r), r the ratio of noise to noise-free force spectrum at a line; coherence is 1 / (1 + r):
    1992 thesis, equations 5.6, 5.8.
    """

    kind: ClassVar[str] = "force_noise"
    summary: ClassVar[str] = "white noise on the force channel"
    stage: ClassVar[Stage] = Stage.NOISE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    ratio: float = parameter(
        1e-3, unit="1", lower=0.0, upper=10.0, doc="noise over the mean force spectrum of the band"
    )

    def on_noise(self, noise: NoiseLevels) -> NoiseLevels:
        if isinstance(self.at, Dof):
            return replace(noise, gauges=(*noise.gauges, (self.at, self.ratio)))
        return replace(noise, force=noise.force + self.ratio)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        return [cls(ratio=ratio)] if (ratio := setup.noise.force_ratio) > 0 else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return all force gauges, and each of several shakers; nowhere if no noise is declared."""
        if setup.noise.force is None:
            return ()
        return (None, *(dof.point for dof in setup.drives)) if setup.n_simultaneous > 1 else (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence is lower than it should be, or the force too strong."""
        drop = float(np.clip(evidence.coherence_drop.mean() / 0.01, 0.0, 1.0))
        return min(1.0, max(drop, evidence.excess, evidence.force_excess))

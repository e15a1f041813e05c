"""Noise of the response channels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup
from modallab.rig.source import NoiseLevels


@EFFECTS.register("response_noise")
@dataclass(frozen=True)
class ResponseNoise(Effect):
    """White noise on every response signal; it lowers the coherence at antiresonances.

    H2 = H (1 + r), r the ratio of noise to noise-free response spectrum at a line; coherence is 1 / (1 +
    r), and H1 stays correct: 1992 thesis, equations 5.7, 5.8.
    """

    kind: ClassVar[str] = "response_noise"
    summary: ClassVar[str] = "white noise on the response channels"
    stage: ClassVar[Stage] = Stage.NOISE
    ratio: float = parameter(
        1e-3, unit="1", lower=0.0, upper=10.0, doc="noise over the mean response spectrum of the band"
    )

    def on_noise(self, noise: NoiseLevels) -> NoiseLevels:
        return replace(noise, response=noise.response + self.ratio)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        return [cls(ratio=ratio)] if (ratio := setup.noise.response_ratio) > 0 else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the rig as a whole; nowhere if no noise is declared that there could be more of."""
        return () if setup.noise.response is None else (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence is lower than it should be."""
        drop = float(np.clip(evidence.coherence_drop.mean() / 0.01, 0.0, 1.0))
        return min(1.0, max(drop, evidence.excess))

"""Leakage: excitation that is not periodic in the record."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup
from modallab.rig.source import Source


@EFFECTS.register("leakage")
@dataclass(frozen=True)
class Leakage(Effect):
    """Share of the source's power that is stationary random instead of periodic in the record.

    For pure random excitation it is 1; for an imperfectly periodic one it is between 0 and 1. The spectra
    become G' = (1 - share) G + share G * W, a convolution with the line shape W of the window: 1992 thesis,
    equation 5.11.
    """

    kind: ClassVar[str] = "leakage"
    summary: ClassVar[str] = "part of the excitation does not repeat with the record"
    stage: ClassVar[Stage] = Stage.ACQUISITION
    share: float = parameter(
        0.1, unit="1", lower=0.0, upper=1.0, doc="share of the source's power that does not repeat"
    )

    def on_source(self, source: Source) -> Source:
        return replace(source, continuous=1 - (1 - source.continuous) * (1 - self.share))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return everywhere; nowhere if nothing of the excitation repeats as declared."""
        return () if EXCITATIONS[setup.analyser.excitation.kind].continuous >= 1 else (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Coherence drops, at resonances most; not where noise of unknown level is fitted to it."""
        near = np.argsort(evidence.by_line)[-len(evidence.freq) // 10 :]
        drop = evidence.coherence_drop.mean(axis=1)
        share = np.clip(drop[near].mean() / (np.abs(drop).mean() + 1e-12) / 3, 0.0, 1.0)
        return 0.1 + 0.9 * float(share)

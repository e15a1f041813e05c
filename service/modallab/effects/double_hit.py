"""Double hit of a hammer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import DOUBLE_HIT_SCAN
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup
from modallab.rig.source import Source


@EFFECTS.register("double_hit")
@dataclass(frozen=True)
class DoubleHit(Effect):
    """Second blow after every blow of a hammer, `ratio` times as large and `delay` later.

    P' = P (1 + r exp(-i omega tau)): the force spectrum has ripples between (1 - r)^2 and (1 + r)^2 of its
    value with the period 1/tau, and so have all responses. The FRF changes only where noise dominates in
    the minima of the ripple, or where a force window removes the second blow from the force but not from
    the response. Halvorsen and Brown (1977), Sound and Vibration 11(11), 8-21.
    """

    kind: ClassVar[str] = "double_hit"
    summary: ClassVar[str] = "second blow of the hammer within the record"
    stage: ClassVar[Stage] = Stage.NOISE
    ratio: float = parameter(
        0.3, unit="1", lower=0.0, upper=1.0, doc="size of the second blow over that of the first"
    )
    delay: float = parameter(
        0.02,
        unit="s",
        lower=1e-5,
        upper=100.0,
        doc="of the second blow",
        absent=None,
        scan_values=(5e-3, 0.02, 0.05),
    )

    def on_source(self, source: Source) -> Source:
        return source.with_filter(self._shaping)

    def _shaping(self, omega: FloatArray) -> ComplexArray:
        return np.asarray(1 + self.ratio * np.exp(-1j * omega * self.delay))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None,) if setup.analyser.excitation.kind == "impact" else ()

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return delays so close that the ripple of neighbours stays in phase over the band."""
        band = setup.analyser.frequency_max
        return {"delay": tuple(np.arange(1, DOUBLE_HIT_SCAN.n_delays + 1) / (2 * band)), "ratio": (0.4,)}

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence that the force spectrum is not that of a single blow."""
        if evidence.force is None:
            return 0.3
        return float(np.clip(evidence.force.std() / (np.abs(evidence.frf).mean() + 1.0), 0.1, 1.0))

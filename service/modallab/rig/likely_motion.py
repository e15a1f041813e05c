"""Expected motion at a DoF in a test, and evidence of nonlinear forces there."""

from dataclasses import dataclass

import numpy as np

from modallab.core.dof import Dof
from modallab.correlation.evidence import Evidence
from modallab.fe.receptance import receptance
from modallab.fe.system import DynamicSystem
from modallab.rig.nonlinear_settings import DISTORTION_EVIDENCE
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class LikelyMotion:
    """Root mean squares at a DoF, and the stiffness and damping that it feels there."""

    displacement: float  # m
    velocity: float  # m/s
    stiffness: float  # N/m, one over the middle of the receptances over the band
    viscous: float  # N s/m, the same of mobilities


def likely_motion(system: DynamicSystem, setup: RigSetup, dof: Dof) -> LikelyMotion:
    """Return the motion of a DoF when the rig drives the bare structure at the declared level."""
    analyser = setup.baseband.analyser
    freq = analyser.freq[1:]
    columns = system.selection((dof, setup.drive))
    alpha = np.abs(receptance(system, freq, columns, columns[:, :1])[:, :, 0])
    omega = 2 * np.pi * freq
    power = analyser.source_density(freq) * analyser.spacing
    return LikelyMotion(
        displacement=float(np.sqrt(power @ alpha[:, 1] ** 2)),
        velocity=float(np.sqrt(power @ (omega * alpha[:, 1]) ** 2)),
        stiffness=float(1 / np.median(alpha[:, 0])),
        viscous=float(1 / np.median(omega * alpha[:, 0])),
    )


def distortion_suspicion(evidence: Evidence) -> float:
    """Return the suspicion of a nonlinear force, 0 to 1, from incoherent response power.

    A nonlinear force that also damps the structure may reduce the total incoherent power: it may remove
    more of the response to noise at resonances than it adds beside them.
    """
    if evidence.response is None:
        return DISTORTION_EVIDENCE.unmeasured
    if _is_too_coherent(evidence):
        return 0.0
    wrong = (
        DISTORTION_EVIDENCE.misfit_only
        if evidence.gaps["response"] > DISTORTION_EVIDENCE.misfit_limit
        else 0.0
    )
    return max(wrong, min(1.0, evidence.excess))


def _is_too_coherent(evidence: Evidence) -> bool:
    """Return whether a nonlinear force that changes the FRFs this much would add more incoherent power.

    The equivalent linearisation of the force changes the FRFs. The rest of the force, about as strong, has
    nothing in common with a random source. Both powers are over the incoherent power predicted without it.
    """
    n, gaps = evidence.random_averages, evidence.gaps
    if n is None:
        return False
    of_linearisation = gaps["frf"] / (2 * n)
    incoherent = np.expm1(np.sqrt(max(gaps["response"] - 1, 0.0) / n))
    return bool(incoherent < DISTORTION_EVIDENCE.least_distortion * of_linearisation)

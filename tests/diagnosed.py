"""A diagnosis as the search would hand it over, without a search: what the tests of its report share."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.result import Diagnosis, FittedEffect, FittedParameter, Rival, Step, Verdict
from modallab.diagnosis.result_curves import DiagnosisCurves
from modallab.diagnosis.result_localisation import Localisation
from tests.diagnosing import model, rig

OUTPUTS = tuple(Dof(n, "Y") for n in (1, 2, 4, 5, 7, 9))
STEP = Step(
    effect=FittedEffect("extra_mass", Dof(4, "Y"), {"mass": FittedParameter(0.03, 0.0004, "kg")}),
    probability=0.9731,
    gap_before=812.0,
    gap_after=1.04,
    held_out_gap_before=790.0,
    held_out_gap_after=1.06,
    held_out_scatter=0.05,
)


def curves(n_freq: int = 60) -> DiagnosisCurves:
    """Return resonances that were predicted 3 % too high, and after an addition as they are."""
    freq = np.linspace(0.0, 400.0, n_freq)

    def frf(resonance: float) -> ComplexArray:
        resonance_term = -(freq**2) / (resonance**2 * (1 + 0.01j) - freq**2)
        return np.asarray(resonance_term[:, None, None] * np.arange(1.0, 7.0)[:, None], complex)

    measured = frf(120.0)
    measured[:, 3] *= 1.5  # the channel that is furthest off
    return DiagnosisCurves(
        freq=freq,
        measured=measured,
        before=frf(123.6),
        after=frf(120.0),
        random_error=np.full(measured.shape, 0.01),
        held_out=np.array([False, False, True, False, False, False]),
        outputs=OUTPUTS,
        inputs=(Dof(1, "Y"),),
    )


def diagnosis(verdict: Verdict = Verdict.EXPLAINED, steps: tuple[Step, ...] = (STEP,)) -> Diagnosis:
    """Return a diagnosis as the search would hand it over."""
    rivals = (
        Rival("extra_mass", Dof(4, "Y"), 0.9731, 1.04),
        Rival("density_error", Members((3,)), 0.0269, 1.31),
    )
    return Diagnosis(
        verdict=verdict,
        located=Localisation(((118.0, 126.0),), (Dof(5, "Y"),), (2,), ("frequency shifts: mode 2 -3.00 %",)),
        steps=steps,
        remaining_gap=1.05,
        remaining_scatter=0.02,
        gaps={"before": {"frf": 1500.0, "force": 130.0}, "after": {"frf": 1.08, "force": 1.02}},
        structure=model(),
        setup=rig(),
        curves=curves(),
        candidates=rivals if steps else (),
        seed=17,
    )

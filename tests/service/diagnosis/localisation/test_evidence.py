import numpy as np
import pytest

from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stiffness_error import StiffnessError
from tests.diagnosing import draw_measurement, predicting, rig


@pytest.mark.parametrize(
    ("factor", "tolerance"),
    [
        (1.002, 1e-4),  # within a resonance: right to first order, the shift being a tenth of its width
        (1.06, 2.5e-3),  # beyond: by the shape, to a step of the shifts looked for
    ],
)
def test_frequency_shifts_are_read_from_the_frfs(factor: float, tolerance: float) -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), [StiffnessError(factor=factor)]))
    found = collect_evidence(predictor, [])
    half_a_line = 1.25 / found.mode_frequency  # more than a step for the first mode alone
    allowed = np.maximum(tolerance, half_a_line) if factor > 1.01 else tolerance
    assert (np.abs(found.frequency_shift - (np.sqrt(factor) - 1)) < allowed).all()


def test_an_armature_is_told_from_the_force_spectra_alone() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExciterArmature(mass=0.05)]))
    evidence = collect_evidence(predictor, [])
    assert evidence.gaps["force"] > 3 > evidence.gaps["frf"]
    assert ExciterArmature.signature(evidence) > 0.5

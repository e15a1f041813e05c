import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.effects.ac_coupling import AcCoupling
from modallab.effects.force_noise import ForceNoise
from modallab.effects.overload import Overload
from modallab.effects.quantisation import Quantisation
from modallab.effects.stiffness_error import StiffnessError
from tests.diagnosing import draw_measurement, predicting, rig

FAULTY = Channels((Dof(5, "Y"),))


def test_noise_that_hardly_lowers_coherence_is_looked_for_all_the_same() -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), [ForceNoise(None, 1e-4)], seed=2))
    evidence = collect_evidence(predictor, [])
    assert evidence.coherence_drop.mean() < 5e-4
    assert max(evidence.gaps.values()) > 2, "and yet it is there"
    assert ForceNoise.signature(evidence) > 10 * DIAGNOSIS.least_suspicion


@pytest.mark.parametrize(
    "effect", [Quantisation(FAULTY, 0.01), Overload(FAULTY, 3.7)], ids=lambda effect: effect.kind
)
def test_what_a_converter_adds_to_one_channel_is_looked_for_though_coherence_hardly_falls(
    effect: Quantisation | Overload,
) -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), [effect], seed=2))
    evidence = collect_evidence(predictor, [])
    assert evidence.coherence_drop.mean() < 5e-4
    assert max(evidence.gaps.values()) > 2, "and yet it is there"
    assert effect.signature(evidence) > 10 * DIAGNOSIS.least_suspicion


def test_an_ac_coupling_is_looked_for_beside_shifted_resonances() -> None:
    hidden = [StiffnessError(None, 1.05), AcCoupling(corner=5.0)]
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), hidden, seed=2))
    evidence = collect_evidence(predictor, [])
    assert AcCoupling.signature(evidence) >= 10 * DIAGNOSIS.least_suspicion

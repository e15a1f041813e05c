from modallab.diagnosis.diagnose import RULED_OUT
from modallab.diagnosis.evidence import gather
from modallab.effects.force_noise import ForceNoise
from tests.diagnosing import drawn, predicting, rig


def test_noise_that_hardly_lowers_coherence_is_looked_for_all_the_same() -> None:
    predictor, _ = predicting(drawn(rig(noise=1e-5), [ForceNoise(None, 1e-4)], seed=2))
    evidence = gather(predictor, [])
    assert evidence.coherence_drop.mean() < 5e-4
    assert max(evidence.gaps.values()) > 2, "and yet it is there"
    assert ForceNoise.signature(evidence) > 10 * RULED_OUT

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.effects.ac_coupling import AcCoupling
from modallab.effects.channel_delay import ChannelDelay
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.force_noise import ForceNoise
from modallab.effects.friction import Friction
from modallab.effects.gain_error import GainError
from modallab.effects.mounted_resonance import MountedResonance
from modallab.effects.overload import Overload
from modallab.effects.quantisation import Quantisation
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.effect import Effect
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


@pytest.mark.parametrize("strain", [0.95, 1.05, 1.3], ids=str)
@pytest.mark.parametrize(
    "effect",
    [
        AcCoupling(corner=5.0),
        ChannelDelay(FAULTY, 1e-4),
        GainError(FAULTY, 1.05),
        MountedResonance(FAULTY, 2e3),
    ],
    ids=lambda effect: effect.kind,
)
def test_an_error_of_a_channel_is_looked_for_beside_shifted_resonances(effect: Effect, strain: float) -> None:
    """Its course is lost in a residual of resonances: that it is not seen does not exclude it."""
    hidden = [StiffnessError(None, strain), effect]
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), hidden, seed=2))
    evidence = collect_evidence(predictor, [])
    assert type(effect).signature(evidence) >= 10 * DIAGNOSIS.least_suspicion


@pytest.mark.parametrize("kind", [ChannelDelay, GainError, MountedResonance, AcCoupling])
def test_an_error_of_a_channel_is_excluded_where_the_frfs_agree(kind: type[Effect]) -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=1e-4), [ExciterArmature(mass=0.05)], seed=2))
    evidence = collect_evidence(predictor, [])
    assert evidence.gaps["force"] > 3
    # by chance, of two numbers a line: 4 standard errors
    assert kind.signature(evidence) < 16 / (2 * len(evidence.freq))


@pytest.mark.parametrize(
    "effect", [ExciterArmature(mass=0.05), StingerAxial(None, 3e5)], ids=lambda effect: effect.kind
)
def test_a_wrong_force_is_looked_into_however_wrong_the_frfs_are(effect: Effect) -> None:
    wrong, right = (
        collect_evidence(predicting(draw_measurement(rig(noise=1e-4), hidden, seed=2))[0], [])
        for hidden in ([StiffnessError(None, 1.05), effect], [StiffnessError(Members((3,)), 1.0002)])
    )
    assert wrong.gaps["frf"] > wrong.gaps["force"] > 3
    assert type(effect).signature(wrong) > 5 * DIAGNOSIS.least_suspicion
    assert type(effect).signature(right) < DIAGNOSIS.least_suspicion, "a force as predicted excludes it"


SEEN_DISTORTION = [
    (1e-5, CubicStiffness(Dof(5, "Y"), 1e10)),
    (1e-5, CubicStiffness(Dof(5, "Y"), 1e12)),
    (1e-5, Friction(Dof(5, "Y"), 0.01)),
    (1e-5, Friction(Dof(5, "Y"), 0.1)),
    (1e-3, CubicStiffness(Dof(5, "Y"), 1e12)),
    (1e-3, Friction(Dof(5, "Y"), 0.1)),
]


@pytest.mark.parametrize(("noise", "force"), SEEN_DISTORTION, ids=str)
def test_a_nonlinear_force_is_looked_for_where_its_distortion_is_seen(noise: float, force: Effect) -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=noise), [force], seed=2))
    evidence = collect_evidence(predictor, [])
    assert evidence.gaps["response"] > 1.2, "its distortion is seen"
    assert type(force).signature(evidence) > 5 * DIAGNOSIS.least_suspicion


def test_no_nonlinear_force_changes_frfs_that_much_and_leaves_the_coherence() -> None:
    """Its equivalent linearisation alone changes FRFs; about as much of it has no part in the coherence."""
    hidden = [StiffnessError(None, 1.05)]
    random, repeated = (
        collect_evidence(predicting(draw_measurement(rig(kind=kind, noise=1e-5), hidden, seed=2))[0], [])
        for kind in ("periodic_random", "pseudo_random")
    )
    assert random.gaps["response"] > 1.2, "the wrong FRFs change the response to noise of the force"
    assert CubicStiffness.signature(random) == Friction.signature(random) == 0
    assert CubicStiffness.signature(repeated) > 0, "distortion by a force that repeats is coherent"

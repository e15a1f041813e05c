"""A response that is velocity or displacement where the log book says acceleration."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels, EffectSpec
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.effects.channel_delay import ChannelDelay
from modallab.effects.gain_error import GainError
from modallab.effects.integrated_response import IntegratedResponse
from modallab.effects.polarity import Polarity
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import chain
from modallab.rig.effect import Effect, build
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from tests.diagnosing import draw_measurement, model, predicting
from tests.diagnosing import rig as small_rig
from tests.rigs import beam_system, dofs, rig

FREQ = np.linspace(2.0, 800.0, 57)
OMEGA = 2 * np.pi * FREQ[:, None]
SETUP = rig(1, 7, 16)
ONE, OTHER = Channels(dofs(7)), Channels(dofs(5))


def inertances(effect: Effect) -> ComplexArray:
    """FRFs (n_freq, n_out) of the beam as the log book reads them."""
    return np.asarray(chain(beam_system(), SETUP, [effect]).respond(FREQ).inertance[0, ..., 0])


def receptances() -> ComplexArray:
    """The same beam's receptances (n_freq, n_out), solved line by line."""
    system = beam_system()
    return np.asarray(
        direct_receptance(system, FREQ, system.selection(dofs(1, 7, 16)), system.selection(dofs(1)))[..., 0]
    )


@pytest.mark.parametrize(
    ("effect", "times", "factor"),
    [
        (IntegratedResponse(), 1, 1.0),  # mobility, m/s per N
        (IntegratedResponse(integrations=2.0, factor=1e6), 0, 1e6),  # receptance, micrometres per N
        (IntegratedResponse(integrations=-1.0, factor=1e-3), 3, 1e-3),
    ],
)
def test_a_response_integrated_once_is_the_mobility_and_twice_the_receptance(
    effect: IntegratedResponse, times: int, factor: float
) -> None:
    wanted = factor * (1j * OMEGA) ** times * receptances()
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(inertances(effect), wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_one_integrated_channel_leaves_the_others_alone() -> None:
    wanted = -(OMEGA**2) * receptances() * np.hstack([OMEGA**0, 1 / (1j * OMEGA), OMEGA**0])
    np.testing.assert_allclose(
        inertances(IntegratedResponse(ONE)), wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max()
    )


def test_the_phase_lags_by_a_quarter_of_a_turn_at_every_line() -> None:
    turn = inertances(IntegratedResponse(ONE))[:, 1] / inertances(GainError(ONE, 1.0))[:, 1]
    np.testing.assert_allclose(np.degrees(np.angle(turn)), -90.0, rtol=1e-12)  # rounding


def test_the_power_falls_with_the_square_of_frequency() -> None:
    setup = rig(1, 7, 16, noise=Noise())
    bare, found = (expected_spectra(chain(beam_system(), setup, e)) for e in ([], [IntegratedResponse()]))
    omega = 2 * np.pi * setup.analyser.freq[1:, None]
    np.testing.assert_allclose(found.xx[0, 1:], bare.xx[0, 1:] / omega**2, rtol=1e-9)  # rounding of sums


def test_a_part_of_an_integration_is_refused_with_what_is_allowed() -> None:
    with pytest.raises(InvalidInputError) as caught:
        build(EffectSpec("integrated_response", None, {"integrations": 0.5}))
    assert caught.value.context == {"field": "integrations", "value": 0.5, "allowed": [-2, -1, 0, 1, 2]}


@pytest.mark.parametrize("share", [0.1, 0.9, 1.4])
def test_a_search_that_scales_it_stays_at_whole_numbers(share: float) -> None:
    assert IntegratedResponse().with_parameters({"integrations": -share}).integrations == -1.0


def suspicion(hidden: list[Effect], noise: float = 1e-5) -> float:
    measured = draw_measurement(small_rig(noise=noise), hidden, seed=2)
    return IntegratedResponse.signature(collect_evidence(predicting(measured)[0], []))


@pytest.mark.parametrize(
    "hidden",
    [
        [],
        [Polarity(OTHER)],
        [GainError(OTHER, 3.0)],
        [ChannelDelay(OTHER, 1e-3)],
        [StiffnessError(None, 1.3)],
    ],
    ids=lambda hidden: " ".join(effect.kind for effect in hidden) or "nothing",
)
def test_it_is_not_looked_for_where_no_ratio_is_like_a_power_of_frequency(hidden: list[Effect]) -> None:
    assert suspicion(hidden) < DIAGNOSIS.least_suspicion


@pytest.mark.parametrize("factor", [1.0, 9.81, 1e3])
@pytest.mark.parametrize("times", [-1.0, 1.0])
def test_it_is_looked_for_beside_a_wrong_modulus_whatever_the_unit(factor: float, times: float) -> None:
    hidden = [IntegratedResponse(OTHER, times, factor), StiffnessError(None, 1.05)]
    assert suspicion(hidden) > 10 * DIAGNOSIS.least_suspicion


@pytest.mark.parametrize(
    "hidden",
    [IntegratedResponse(OTHER), IntegratedResponse(None, 1.0, 1e3)],
    ids=lambda effect: str(effect.at),
)
def test_among_all_suspects_it_is_found_with_its_unit(hidden: IntegratedResponse) -> None:
    found = diagnose(model(), draw_measurement(small_rig(), [hidden]), hold_out=list(dofs(2)))
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, hidden.at)
    assert step.effect.parameters["integrations"].value == 1.0
    factor = step.effect.parameters["factor"]
    # four standard errors, one time in 16,000 beyond
    assert abs(factor.value - hidden.factor) < 4 * factor.standard_error


def test_a_displacement_in_millimetres_is_found_by_name_where_noise_drowns_its_upper_band() -> None:
    """The noise is white: of a displacement it hides the high lines, and with them most of the course."""
    measured = draw_measurement(small_rig(), [IntegratedResponse(OTHER, 2.0, 1e3)])
    kinds = ["integrated_response", "gain_error", "polarity", "mounted_resonance"]
    (step,) = diagnose(model(), measured, suspects=kinds, hold_out=list(dofs(2))).steps
    assert (step.effect.kind, step.effect.parameters["integrations"].value) == ("integrated_response", 2.0)


@pytest.mark.parametrize("noise", [1e-5, 1e-4, 3e-4])
def test_a_displacement_is_looked_for_where_noise_drowns_all_but_its_lowest_lines(noise: float) -> None:
    assert suspicion([IntegratedResponse(OTHER, 2.0)], noise) > DIAGNOSIS.least_suspicion

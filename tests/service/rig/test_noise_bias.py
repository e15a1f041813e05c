"""FRFs freed of what noise makes of them, against the noise-free ones."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.receptance import direct_receptance
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.noise_bias import without_noise_bias
from modallab.rig.setup import RigSetup

BEAM = STRUCTURES["chapter-5-beam"]()
SENSORS = tuple(Dof(node, "Y") for node in (1, 6, 12, 17))
NOISE = Noise(force=0.05, response=1e-5)


def noisy(estimator: str = "h1", kind: str = "periodic_random", **parts: object) -> Measurement:
    """Return spectra without random error: what is off is bias."""
    analyser = Analyser(800.0, 161, estimator=estimator, excitation=ExcitationSetting(kind))
    setup = RigSetup(SENSORS[:1], SENSORS, noise=NOISE, analyser=analyser)
    return measure(BEAM, replace(setup, **parts), route=Route.EXPECTED, rng=np.random.default_rng(0))  # type: ignore[arg-type]


def off(measurement: Measurement) -> tuple[float, float]:
    """Return the largest relative error at strong lines, before and after."""
    frf, system = measurement.frf, assemble(BEAM)
    lines = frf.freq > 0
    outputs, inputs = system.selection(frf.outputs), system.selection(frf.inputs)
    known = direct_receptance(system, frf.freq[lines], outputs, inputs)
    strong = measurement.coherence.reshape(known.shape[0] + 1, *known.shape[1:])[lines] > 0.9  # type: ignore[union-attr]
    before, after = (
        float(np.abs(one.between(1e-9, np.inf).to(FrfKind.RECEPTANCE).values / known - 1)[strong].max())
        for one in (frf, without_noise_bias(measurement)[0])
    )
    return before, after


@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
def test_noise_is_taken_off_whatever_the_estimator(estimator: str) -> None:
    before, after = off(noisy(estimator))
    assert before > 0.02
    # the noise of responses is white as they are seen, so that both noises are told exactly
    assert after < 1e-3


def test_where_the_force_drops_out_more_is_taken_off() -> None:
    before, after = off(noisy(exciter=Exciter(armature_mass=0.1)))
    assert before > 0.06
    # both noises are found by turns, and a thousandth of a force is left when the turns end
    assert after < 2e-3


def test_roving_accelerometers_have_no_random_number_in_common() -> None:
    test = noisy(accelerometers=Accelerometers(0.0, roving=True))
    assert off(test)[1] < 1e-3
    assert without_noise_bias(test)[1] is None


def test_variance_that_channels_share_is_that_of_the_noise_over_the_averages() -> None:
    test = noisy()
    shared = without_noise_bias(test)[1]
    assert shared is not None
    np.testing.assert_allclose(shared[1:], 0.05 / (2 * (test.averages - 2)), rtol=1e-3)


@pytest.mark.parametrize("missing", ["coherence", "force_spectrum", "averages", "steadiness"])
def test_where_noise_cannot_be_told_frfs_stay_as_they_are(missing: str) -> None:
    test = noisy(kind="random") if missing == "steadiness" else noisy()
    if missing == "averages":
        test = replace(test, averages=2.0)
    elif missing != "steadiness":
        test = replace(test, **{missing: None})  # type: ignore[arg-type]
    frf, shared = without_noise_bias(test)
    assert frf is test.frf
    assert shared is None


def test_forces_that_act_at_once_are_left_alone() -> None:
    test = noisy(drives=SENSORS[:2])
    assert test.frf.values.shape[2] == 2
    assert without_noise_bias(test)[0] is test.frf


def test_every_blow_point_of_a_roving_hammer_is_a_run_of_its_own() -> None:
    test = noisy(kind="impact", drives=SENSORS, responses=SENSORS[:2], exciter=Exciter(kind="hammer"))
    assert test.coherence is not None
    assert test.coherence.ndim == 3
    frf, shared = without_noise_bias(test)
    assert shared is not None
    np.testing.assert_allclose(shared[:, 0], shared[:, 1])
    assert np.ptp(np.abs(frf.values / test.frf.values)[1:, 0], axis=1).max() > 0

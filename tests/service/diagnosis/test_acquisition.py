"""What mains and converter do is named for what it is."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.effects.mains_hum import MainsHum
from modallab.effects.overload import Overload
from modallab.effects.quantisation import Quantisation
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, model, rig
from tests.humming import with_hum

SUSPECTS = ["mains_hum", "overload", "quantisation", "response_noise", "force_noise", "extra_mass"]
FIVE = Channels((Dof(5, "Y"),))


@pytest.mark.parametrize(
    "missing",
    [
        MainsHum(ratio=0.03, frequency=60.0),
        MainsHum(FIVE, ratio=0.05),  # lines 20, 60, 100 and 140: even steps would hold out none of them
        Overload(level=1.5),
        Overload(Channels(rig().responses), level=1.5),  # the one amplifier of a roving accelerometer
        Quantisation(step=0.1),
    ],
    ids=lambda effect: f"{effect.kind} {effect.at}",
)
def test_it_is_found_with_its_place_and_its_numbers(missing: Effect) -> None:
    found = diagnose(model(), draw_measurement(rig(), [missing], seed=1), suspects=SUSPECTS, max_effects=2)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (missing.kind, missing.at)
    for name, value in missing.parameters.items():
        number = step.effect.parameters[name]
        # four standard errors of a fit whose residuals are nearly normal
        assert np.isclose(number.value, value, atol=4 * number.standard_error + 1e-3 * value), name


def test_hum_in_force_and_responses_is_named_alone() -> None:
    """The phase of a hum in two channels is constant: no average removes it from an FRF."""
    test = draw_measurement(rig(kind="random", window="hann", noise=1e-5), seed=1)
    for order, amplitude in ((1, 1.0), (2, 0.6), (3, 0.3)):
        test = with_hum(test, 24 * order, 0.5 * amplitude, 5.0 * amplitude)
    found = diagnose(model(), test, suspects=SUSPECTS, max_effects=2)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert step.effect.kind == "mains_hum"
    assert step.effect.parameters["frequency"].value == pytest.approx(60.0, abs=0.1)
    assert step.effect.parameters["second_harmonic"].value == pytest.approx(
        0.6, rel=0.3
    )  # powers are known to 17 %

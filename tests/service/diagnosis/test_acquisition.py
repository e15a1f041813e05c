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

SUSPECTS = ["mains_hum", "overload", "quantisation", "response_noise", "force_noise", "extra_mass"]
FIVE = Channels((Dof(5, "Y"),))


@pytest.mark.parametrize(
    "missing",
    [
        MainsHum(ratio=0.03, frequency=60.0),
        MainsHum(FIVE, ratio=0.05),  # lines 20, 60, 100 and 140: even steps would hold out none of them
        Overload(level=1.5),
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

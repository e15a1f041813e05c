"""Hum at lines that coarse predictions leave out."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching.single_lines import visible_at_single_lines
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.mains_hum import MainsHum
from modallab.rig.effect import Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, predicting, rig

HUM = MainsHum(None, 0.02, 50.0, second_harmonic=0.5)
OF_ONE = MainsHum(Channels((Dof(4, "Y"),)), 0.02, 50.0)


def long_records() -> RigSetup:
    """Return a rig with lines of 0.25 Hz to 100 Hz: every third one is coarse, that of 50 Hz is not."""
    setup = rig(noise=1e-4)
    return replace(setup, analyser=replace(setup.analyser, frequency_max=100.0, n_lines=401))


def drawn(*hidden: Effect) -> Measurement:
    return draw_measurement(long_records(), hidden, seed=2)


@pytest.mark.parametrize(
    ("hidden", "expected"),
    [([HUM], [None]), ([OF_ONE], [OF_ONE.at]), ([], []), ([ExtraMass(Dof(4, "Y"), 0.05)], [])],
    ids=["all channels", "one channel", "nothing", "a mass"],
)
def test_hum_is_looked_for_in_the_channels_whose_lines_show_it(
    hidden: Sequence[Effect], expected: Sequence[object]
) -> None:
    predictor, observed = predicting(drawn(*hidden))
    suspects = [ExtraMass(Dof(4, "Y")), MainsHum(None), *(MainsHum(Channels((d,))) for d in observed.outputs)]
    assert [e.at for e in visible_at_single_lines(predictor, fit(predictor, ()), suspects)] == expected


def test_hum_between_coarse_lines_is_named_with_a_harmonic_at_the_end_of_the_band() -> None:
    test = drawn(HUM)
    assert (200 % predicting(test)[0].step) != 0, "the line of 50 Hz is coarse"
    found = diagnose(model(), test, suspects=["mains_hum", "extra_mass", "response_noise"])
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == ("mains_hum", None)
    for name in ("ratio", "second_harmonic"):
        parameter = step.effect.parameters[name]
        assert abs(parameter.value - HUM.parameters[name]) < 4 * parameter.standard_error  # four errors

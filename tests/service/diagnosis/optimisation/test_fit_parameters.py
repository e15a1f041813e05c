"""Parameters of effects as coordinates: which of them a fit varies."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.mains_hum import MainsHum
from modallab.fe.assembly import assemble
from tests.diagnosing import model


def names(effect: MainsHum) -> list[str]:
    return [parameter.name for parameter in ParameterVector([effect]).parameters]


def test_an_optional_parameter_is_varied_where_it_has_left_its_default() -> None:
    assert names(MainsHum()) == ["ratio", "frequency"]
    assert names(MainsHum(third_harmonic=0.5)) == ["ratio", "frequency", "third_harmonic"]
    (extended,) = MainsHum().variants(assemble(model()))
    assert names(extended) == [
        "ratio",
        "frequency",
        "second_harmonic",
        "third_harmonic",
        "higher_harmonics",
    ]


def test_values_of_others_stay() -> None:
    hum = MainsHum(ratio=0.02, second_harmonic=0.4)
    vector = ParameterVector([hum])
    (again,) = vector.with_values(vector.start)
    assert again.parameters == pytest.approx(hum.parameters, rel=1e-12)  # rounding of logarithms
    assert again.parameters["third_harmonic"] == hum.third_harmonic


def test_effects_in_bursts_change_by_no_more_than_a_ratio() -> None:
    mass, cubic = ExtraMass(Dof(2, "Y"), 0.01), CubicStiffness(Dof(4, "Y"), 3e9)
    free, limited = ParameterVector([mass, cubic]), ParameterVector([mass, cubic], 2.0)
    assert limited.low[0] == free.low[0]
    assert limited.high[0] == free.high[0]
    assert np.exp([limited.low[1], limited.high[1]]) == pytest.approx([1.5e9, 6e9], rel=1e-12)  # rounding

"""Parameters of effects as coordinates: which of them a fit varies."""

import pytest

from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
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

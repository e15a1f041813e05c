"""Numbers are rounded to their uncertainty, and results say in a sentence what they are."""

import pytest

from modallab_client._numbers import concise, gap, rounded
from modallab_client._read import read_as
from modallab_client.methods.updates import update_of
from modallab_client.results import Diagnosis, FittedParameter
from tests.client.fake import DIAGNOSIS, UPDATE, completed


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.010619, 7e-6, "0.010619(7)"),
        (1.3, 1e-8, "1.300000000(10)"),  # a single 1 could be anything from 0.5 to 1.5
        (2.0e6, 3.1e4, "2.00(3)e6"),
        (50000.0, 700.0, "50000(700)"),
        (12345.0, 1400.0, "12300(1400)"),
        (-3.2e-5, 1.2e-7, "-3.200(12)e-5"),
        (0.0304, 0.00195, "0.0304(20)"),
        (9.996, 0.04, "10.00(4)"),
        (0.0, 0.002, "0.000(2)"),
        (0.05, None, "0.05"),
        (0.05, float("nan"), "0.05"),
    ],
)
def test_a_value_ends_where_its_error_begins(value: float, error: float | None, text: str) -> None:
    assert concise(value, error) == text


def test_a_column_of_values_has_two_digits_of_their_errors() -> None:
    assert [rounded(1.30183, error) for error in (0.00027, 0.02, 3.0, None)] == [
        "1.30183",
        "1.302",
        "1.3",
        "1.302",
    ]
    assert [gap(value) for value in (0.32011, 0.9997, 12.34, 812.3, 36292074513.62)] == [
        "0.320",
        "1.00",
        "12.3",
        "812",
        "3.6e10",
    ]


def test_a_diagnosis_says_what_where_and_how_much() -> None:
    found = read_as(Diagnosis, completed(Diagnosis, DIAGNOSIS))
    assert found.summary() == (
        "Explained: extra mass at 7:+Y, mass 0.0500(4) kg. "
        "The gap between test and prediction falls from 812 to 1.04; random error alone leaves 1."
    )
    nothing = completed(
        Diagnosis, DIAGNOSIS | {"steps": [], "verdict": "nothing_missing", "remaining_gap": 1.02}
    )
    said = read_as(Diagnosis, nothing).summary()
    assert said == "Nothing missing. The gap is 1.02; random error alone leaves 1."


def test_a_size_without_a_level_is_not_told() -> None:
    free = completed(FittedParameter, {"value": None, "standard_error": None, "unit": "N/m^3"})
    assert read_as(FittedParameter, free).in_short() == "needs a level"


def test_an_update_says_what_it_corrected() -> None:
    said = update_of(UPDATE).summary()
    assert said.startswith("The coefficients stand still. Corrected: ")
    assert "stiffness of 11 2.00(2), mass of 1 2.000(10), stiffness of 12 1.99." in said

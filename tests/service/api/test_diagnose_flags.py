"""The flags of `modallab diagnose` are the options of a diagnosis."""

from typing import Any

import click
import pytest

from modallab.diagnosis.options import DiagnosisOptions
from modallab_cli.app import app
from modallab_cli.flags import request_of

# Files, output, and what belongs to the measurement; `act` needs a rig that a file has not.
NO_OPTIONS = {
    "model",
    "measured",
    "rig",
    "mesh",
    "report",
    "averages",
    "picture",
    "as_json",
    "server",
    "help",
}
NO_OPTIONS |= {"title", "object", "author", "date"}


def flags() -> dict[str, Any]:
    """Return the parameters of the command by name, as click has them."""
    return {str(parameter.name): parameter for parameter in app.commands["diagnose"].params}


def test_every_option_but_the_running_of_tests_is_a_flag_without_a_default_of_its_own() -> None:
    derived = {name: flag for name, flag in flags().items() if name not in NO_OPTIONS}
    assert derived.keys() == DiagnosisOptions.specs().keys() - {"act"}
    assert not any(flag.default for flag in derived.values())


def test_help_says_meaning_bounds_and_default() -> None:
    specs = DiagnosisOptions.specs()
    for name in flags().keys() - NO_OPTIONS:
        assert specs[name].doc in flags()[name].help
    assert "1 to 8" in flags()["max_effects"].help
    assert f"default: {specs['max_effects'].default}" in flags()["max_effects"].help
    assert "default: all" in flags()["suspects"].help
    assert "more than 0 and at most 1" in flags()["noise_floor"].help
    assert "modal_loss_factor" in flags()["tolerances"].help


def test_flags_that_may_be_repeated_have_a_singular_name() -> None:
    assert set(flags()["tolerances"].opts) == {"--tolerances", "--tolerance"}
    assert set(flags()["suspects"].opts) == {"--suspects", "--suspect"}
    assert set(flags()["hold_out"].opts) == {"--hold-out"}


def test_a_flag_left_out_is_no_part_of_the_request() -> None:
    assert request_of(DiagnosisOptions, {"seed": None, "suspects": [], "max_effects": 0}) == {
        "max_effects": 0
    }


def test_values_of_nested_options_go_to_the_option_that_takes_them() -> None:
    given = {"hold_out": ["7:+Y", "0.1", "3:+Y"], "tolerances": ["modulus=0.01", "delay=1e-6"]}
    assert request_of(DiagnosisOptions, given) == {
        "hold_out": {"dofs": ["7:+Y", "3:+Y"], "fraction": 0.1},
        "tolerances": {"modulus": 0.01, "delay": 1e-6},
    }
    assert request_of(DiagnosisOptions, {"tolerances": ["careful"]}) == {"tolerances": "careful"}
    assert request_of(DiagnosisOptions, {"hold_out": ["fraction=0.2"]}) == {"hold_out": {"fraction": 0.2}}


def test_bands_are_pairs_of_numbers() -> None:
    assert set(flags()["bands"].opts) == {"--bands", "--band"}
    assert request_of(DiagnosisOptions, {"bands": ["50:400", "5e2:600.5"], "exclude": []}) == {
        "bands": [[50.0, 400.0], [500.0, 600.5]]
    }


@pytest.mark.parametrize(
    "given",
    [
        {"hold_out": ["0.1", "0.2"]},
        {"tolerances": ["0.1"]},
        {"tolerances": ["modulus=much"]},
        {"tolerances": ["=1"]},
        {"bands": ["50"]},
        {"exclude": ["50:high"]},
    ],
)
def test_values_that_no_option_takes_are_refused(given: dict[str, list[str]]) -> None:
    with pytest.raises(click.BadParameter):
        request_of(DiagnosisOptions, given)

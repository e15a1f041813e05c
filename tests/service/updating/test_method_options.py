"""What methods may be told: the options that their requests take, with the defaults that they have."""

from typing import Any

import pytest

from modallab.core.errors import InvalidInputError
from modallab.updating.method_options import METHODS, method_options


@pytest.mark.parametrize("method", METHODS)
def test_the_defaults_of_the_specifications_are_those_of_a_run(method: str) -> None:
    options: Any = METHODS[method].options
    defaults = {name: spec.default for name, spec in method_options(method).items()}
    assert defaults
    assert options(**defaults) == options()


@pytest.mark.parametrize("method", METHODS)
def test_bounds_are_those_that_are_kept(method: str) -> None:
    options: Any = METHODS[method].options
    for name, spec in method_options(method).items():
        beyond: float | str = "neither"
        if not spec.choices:
            assert spec.upper is not None
            beyond = 2 * spec.upper
        with pytest.raises(InvalidInputError) as refused:
            options(**{name: beyond})
        assert refused.value.context["field"] == name


def test_a_method_that_there_is_not_is_named() -> None:
    with pytest.raises(InvalidInputError, match="no updating method called 'guess'"):
        method_options("guess")


def test_a_method_is_told_only_what_means_something_to_it() -> None:
    at_once, two_stage = method_options("one_shot"), method_options("inverse_eigensensitivity")
    assert "suspect_threshold" not in at_once
    assert at_once["prior"].choices == ("sparse", "common", "range")
    assert at_once["underdetermined"].default == "refused"
    assert "prior" not in two_stage
    assert "damping_threshold" not in two_stage

"""The options of each method, and the refusal of others."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.extraction.method_options import OPTIONS, method_options, options_for
from modallab.extraction.options import (
    Damping,
    DistantLinesOptions,
    ExtractionOptions,
    GlobalOptions,
    SingleModeOptions,
)
from modallab.extraction.single_mode.method import EXTRACTION_METHODS

GIVEN = {
    "lines": SingleModeOptions(lines=12),
    "leave_out": DistantLinesOptions(leave_out=4),
    "max_order": GlobalOptions(max_order=30),
}


@pytest.mark.parametrize("kind", OPTIONS)
@pytest.mark.parametrize("name", GIVEN)
def test_a_method_takes_its_own_options_and_no_other(kind: str, name: str) -> None:
    if name in method_options(kind):
        assert getattr(options_for(kind, GIVEN[name]), name) == getattr(GIVEN[name], name)
    else:
        with pytest.raises(InvalidInputError, match=f"{kind} has no option '{name}'") as refused:
            options_for(kind, GIVEN[name])
        assert refused.value.context["field"] == name


@pytest.mark.parametrize("kind", OPTIONS)
def test_options_common_to_all_methods_become_those_of_a_method(kind: str) -> None:
    options = options_for(kind, ExtractionOptions(Damping.VISCOUS))
    assert type(options) is OPTIONS[kind]
    assert options.damping is Damping.VISCOUS
    assert options_for(kind, None) == OPTIONS[kind]()


@pytest.mark.parametrize("kind", EXTRACTION_METHODS)
def test_a_method_that_leaves_lines_out_says_so(kind: str) -> None:
    assert EXTRACTION_METHODS[kind].leaves_out == ("leave_out" in method_options(kind))


def test_leaving_no_line_out_is_no_demand() -> None:
    assert options_for("circle_fit", DistantLinesOptions(leave_out=0)) == OPTIONS["circle_fit"]()


def test_an_unknown_method_is_refused_with_those_there_are() -> None:
    with pytest.raises(InvalidInputError) as refused:
        method_options("guess")
    assert {"dobson", "lscf"} <= set(refused.value.context["allowed"])

"""What a method may be told, and what it refuses."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.extraction.method_options import check_method_options, method_options
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.options import ExtractionOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.extraction.single_mode.plan import plan

EVERY = ExtractionOptions(lines=12, leave_out=4, max_order=30)


@pytest.mark.parametrize("kind", [*EXTRACTION_METHODS, *GLOBAL_METHODS])
def test_a_method_takes_what_it_offers_and_nothing_else(kind: str) -> None:
    able = method_options(kind)
    check_method_options(kind, ExtractionOptions())
    for name in ("lines", "leave_out", "max_order"):
        asked = ExtractionOptions(**{name: getattr(EVERY, name)})
        if name in able:
            check_method_options(kind, asked)
        else:
            with pytest.raises(InvalidInputError, match=f"{kind} has no option '{name}'") as refused:
                check_method_options(kind, asked)
            assert refused.value.context["field"] == name


@pytest.mark.parametrize("kind", EXTRACTION_METHODS)
def test_what_is_offered_is_what_the_plan_of_the_fits_can_do(kind: str) -> None:
    asked = ExtractionOptions(leave_out=4)
    if "leave_out" in method_options(kind):
        assert plan(kind, asked, None).leave_out == 4
    else:
        with pytest.raises(InvalidInputError):
            plan(kind, asked, None)


def test_leaving_no_line_out_is_no_demand() -> None:
    check_method_options("circle_fit", ExtractionOptions(leave_out=0))


def test_an_unknown_method_is_refused_with_those_there_are() -> None:
    with pytest.raises(InvalidInputError) as refused:
        method_options("guess")
    assert {"dobson", "lscf"} <= set(str(refused.value.context["allowed"]).split(", "))

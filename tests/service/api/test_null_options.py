"""An option of null is an option left out, whatever the method; a name that no method has is refused."""

from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from modallab.api.modal_models.schemas import ModalModelStart
from modallab.api.updates.schemas import UpdateStart
from modallab.core.errors import InvalidInputError
from modallab.extraction.method_options import OPTIONS
from modallab.updating.method_options import METHODS

EXTRACTION_NAMES = {name for options in OPTIONS.values() for name in options.specs()}
UPDATE_NAMES = {name for method in METHODS.values() for name in method.options.specs()}


def extraction(method: str, options: dict[str, Any]) -> Any:
    """Return the options of an extraction as its task takes them."""
    body = {"measurement_id": "m1", "method": method, "options": options}
    return TypeAdapter(ModalModelStart).validate_python(body).to_task()[1].options


@pytest.mark.parametrize("method", OPTIONS)
def test_null_is_an_option_of_extraction_left_out(method: str) -> None:
    assert extraction(method, dict.fromkeys(EXTRACTION_NAMES)) == extraction(method, {})


@pytest.mark.parametrize("method", METHODS)
def test_null_is_an_option_of_an_update_left_out(method: str) -> None:
    body = {"structure_id": "s1", "modal_model_id": "m1", "method": method}
    with_null, without = (
        TypeAdapter(UpdateStart).validate_python(body | {"options": options}).options
        for options in (dict.fromkeys(UPDATE_NAMES), {})
    )
    assert with_null == without


def test_a_value_of_another_method_and_an_unknown_name_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="no option 'leave_out'"):
        extraction("circle_fit", {"leave_out": 2})
    with pytest.raises(ValidationError, match="leave_outt"):
        extraction("dobson", {"leave_outt": None})

"""Whatever the document allows to be sent about keys, with a key, is answered as it says."""

from contextlib import suppress
from typing import Any

import pytest
import schemathesis
from hypothesis import given
from hypothesis.errors import Unsatisfiable
from schemathesis.generation import GenerationMode

from tests.service.api.authorisation import School, fill, open_school
from tests.service.api.test_openapi import CHECKED, _for_httpx


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes, and what a student made."""
    school = open_school(service)
    fill(school)
    return school


@pytest.mark.parametrize("caller", ["instructor", "admin"])
@pytest.mark.parametrize("mode", list(GenerationMode))
def test_a_key_gets_the_documented_statuses(school: School, mode: Any, caller: str) -> None:
    document = school.service.app.openapi()
    faults: list[str] = []

    def send(case: Any) -> None:
        if mode is GenerationMode.POSITIVE and case.method in ("GET", "POST") and case.path_parameters:
            case.path_parameters["id"] = school.ids["class" if "/classes" in case.path else "student"]
        if mode is GenerationMode.POSITIVE and isinstance(case.body, dict) and "key" in case.body:
            case.body["key"] = school.keys[caller]
        call = case.as_transport_kwargs(base_url="http://localhost:8000")
        call = {name: value for name, value in call.items() if name != "cookies" and value is not None}
        call["headers"] = dict(call.get("headers") or {}) | {"Authorization": f"Bearer {school.keys[caller]}"}
        reply = school.service.request(call.pop("method"), call.pop("url"), **_for_httpx(call))
        documented = document["paths"][case.path][case.method.lower()]["responses"]
        is_wrong = str(reply.status_code) not in documented or reply.status_code >= 500
        if mode is GenerationMode.POSITIVE and case.method == "POST" and case.media_type != "text/csv":
            # a name that the class has already, and what is not there to be shared
            is_wrong = is_wrong or (reply.status_code == 422 and "names" not in reply.text)
        if is_wrong:
            faults.append(f"{case.as_curl_command()} -> {reply.status_code} {reply.text[:300]}")

    for result in schemathesis.openapi.from_dict(document).get_all_operations():
        operation: Any = result.ok()  # type: ignore[union-attr]
        if operation.tags == ["keys"]:
            with suppress(Unsatisfiable):
                CHECKED(given(case=operation.as_strategy(generation_mode=mode))(send))()
    assert not faults, "\n".join(faults)

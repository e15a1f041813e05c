"""Nothing that a student can get tells what an assignment hides: `tests.faults.sealed` in short."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from modallab.api.settings import ServiceSettings
from modallab.jobs import sealing
from tests.faults.sealed import Reply, Secret, found, searched
from tests.service.api.authorisation import School, open_school
from tests.service.api.conftest import service_of
from tests.service.api.test_authorisation import OPERATIONS

Search = tuple[School, list[Reply], list[Secret]]


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Search]:
    """What a student got of two assignments, and what may not be in it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sealing, "SEALING", replace(sealing.SEALING, step=0.0))
        with service_of(ServiceSettings(data=tmp_path_factory.mktemp("data"))) as service:
            school = open_school(service)
            yield school, *searched(school, 2)


def test_no_reply_to_a_student_has_what_is_hidden(search: Search) -> None:
    _, replies, hidden = search
    assert found(replies, hidden) == []


def test_the_search_asks_every_operation_about_what_is_there(search: Search) -> None:
    _, replies, _ = search
    asked = {reply.request.split("?")[0] for reply in replies}
    good = {reply.request.split("?")[0] for reply in replies if reply.status < 300}
    for method, path in OPERATIONS.values():
        before, _, after = path.partition("{id}")
        if method == "GET" and "{family}" not in path:
            assert any(
                request.startswith(f"GET {before}") and request.endswith(after) for request in asked
            ), path
        if method == "GET" and path.startswith(("/v1/measurements/{id}", "/v1/jobs", "/v1/assignments")):
            is_told = any(request.startswith(f"GET {before}") and request.endswith(after) for request in good)
            # No time records and no estimates are kept of sealed measurements.
            assert is_told == (not path.endswith(("/truth", "/records", "/estimates"))), path


def test_the_search_finds_what_the_instructor_is_told(search: Search) -> None:
    school, _, hidden = search
    made = school.send("instructor", "GET", "/v1/measurements").json()["items"][0]["id"]
    truth = school.send("instructor", "GET", f"/v1/measurements/{made}/truth")
    named = {line.split()[0] for line in found([Reply("GET truth", 200, truth.content)], hidden)}
    assert named == {"kind", "place", "value"}


def test_four_bytes_are_found_where_two_replies_have_them() -> None:
    four, eight = Secret("value", b"abcd"), Secret("value", b"abcdefgh")

    def reply(id: str, content: bytes) -> Reply:
        return Reply(f"GET /v1/measurements/{id * 24}/arrays", 200, content)

    assert found([reply("1", b"_abcd_"), reply("1", b"abcd")], [four]) == []
    assert len(found([reply("1", b"_abcd_"), reply("2", b"abcd")], [four])) == 2
    assert len(found([reply("1", b"_abcdefgh_")], [eight])) == 1

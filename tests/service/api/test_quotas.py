"""Quotas over HTTP: whoever has too much is told so, and others notice nothing."""

from typing import Any

import pytest

from modallab.api.settings import ServiceSettings
from modallab.jobs.runner import QueueQuotaError
from tests.service.api.authorisation import BEAM, RIG, School, open_school

ROOM = 20_000  # B: a beam takes about 7 kB


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> ServiceSettings:
    """Settings of a service that stores little for each key."""
    return ServiceSettings(data=tmp_path_factory.mktemp("data"), key_stored_bytes=ROOM)


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes."""
    return open_school(service)


def test_a_key_for_which_too_much_is_stored_stores_no_more_until_it_removes_something(school: School) -> None:
    made: list[str] = []
    while (reply := school.send("student", "POST", "/v1/structures", json=BEAM)).status_code == 201:
        made.append(reply.json()["id"])
        assert len(made) < 100
    assert (reply.status_code, reply.json()["code"]) == (429, "storage_quota")
    assert int(reply.headers["retry-after"]) >= 1
    assert f"{ROOM}" in reply.json()["context"]["allowed"]
    assert school.send("student", "POST", "/v1/rigs", json=RIG).status_code == 429
    assert school.send("student", "GET", f"/v1/structures/{made[0]}").status_code == 200
    assert school.send("same class", "POST", "/v1/structures", json=BEAM).status_code == 201
    for id in made:
        assert school.send("student", "DELETE", f"/v1/structures/{id}").status_code == 204
    assert school.send("student", "POST", "/v1/structures", json=BEAM).status_code == 201


def test_the_quotas_are_among_the_limits(school: School, settings: ServiceSettings) -> None:
    listed = school.send("student", "GET", "/v1/limits").json()["items"]
    limits = {limit["name"]: (limit["value"], limit["unit"]) for limit in listed}
    assert limits["key_stored_bytes"] == (ROOM, "bytes")
    assert limits["class_stored_bytes"] == (settings.class_stored_bytes, "bytes")
    assert limits["key_queue_length"] == (settings.key_queue_length, "jobs")
    assert limits["class_queue_length"] == (settings.class_queue_length, "jobs")


def test_too_many_waiting_jobs_are_a_429_that_says_when_to_come_again(
    school: School, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_given: object, **_more: object) -> None:
        raise QueueQuotaError("as many jobs of this key wait as may", allowed=1)

    beam = school.send("same class", "POST", "/v1/structures", json=BEAM).json()["id"]
    rig = school.send("same class", "POST", "/v1/rigs", json=RIG).json()["id"]
    monkeypatch.setattr(school.service.app.state.jobs, "submit", full)
    body = {"structure_id": beam, "rig_id": rig}
    reply = school.send("same class", "POST", "/v1/measurements", json=body)
    assert (reply.status_code, reply.json()["code"]) == (429, "queue_quota")
    assert int(reply.headers["retry-after"]) >= 1

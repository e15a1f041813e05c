"""Database or disk away: every route says so, and the service says whether it can work."""

import sqlite3
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest
from sqlalchemy.exc import OperationalError

from modallab.api import about


def away(*_given: object, **_more: object) -> NoReturn:
    raise OperationalError("", {}, sqlite3.OperationalError("database is locked"))


@pytest.mark.parametrize("path", ["/v1/structures", "/v1/structures/5f0c31", "/v1/jobs", "/v1/ready"])
def test_a_database_that_is_away_is_a_503_that_says_when_to_come_again(
    service: Any, monkeypatch: pytest.MonkeyPatch, path: str
) -> None:
    monkeypatch.setattr("modallab.store.sql.SqlShelf.list", away)
    monkeypatch.setattr("modallab.store.sql.SqlShelf.get", away)
    monkeypatch.setattr("modallab.jobs.book.JobBook.find", away)
    reply = service.request("GET", path)
    assert (reply.status_code, reply.json()["code"]) == (503, "service_unavailable")
    assert int(reply.headers["retry-after"]) >= 1


def test_a_wrong_question_to_the_database_stays_a_fault(
    service: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong(*_given: object, **_more: object) -> NoReturn:
        raise OperationalError("", {}, sqlite3.OperationalError("no such table: things"))

    monkeypatch.setattr("modallab.store.sql.SqlShelf.list", wrong)
    assert service.request("GET", "/v1/structures").status_code == 500


def test_a_service_that_has_all_it_needs_is_ready(service: Any) -> None:
    assert service.get("/v1/ready") == {"status": "ready", "database": True, "disk": True, "worker": True}


def test_a_service_without_room_or_worker_is_not_ready(service: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(about, "disk_usage", lambda _path: SimpleNamespace(free=1000))
    monkeypatch.setattr(service.app.state.jobs, "is_served", lambda: False)
    reply = service.request("GET", "/v1/ready")
    assert (reply.status_code, reply.json()["code"]) == (503, "not_ready")
    assert reply.json()["context"] == {"free_bytes": 1000, "database": True, "disk": False, "worker": False}

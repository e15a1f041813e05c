"""Outages of the database: told from wrong questions, and waited for."""

import errno
import sqlite3
from collections.abc import Callable

import psycopg
import pytest
from sqlalchemy.exc import InterfaceError, OperationalError, ProgrammingError

from modallab.jobs import outages
from modallab.jobs.outages import is_outage, patiently

LOCKED = OperationalError("", {}, sqlite3.OperationalError("database is locked"))


@pytest.mark.parametrize(
    ("error", "outage"),
    [
        (LOCKED, True),
        (OperationalError("", {}, sqlite3.OperationalError("database or disk is full")), True),
        (OperationalError("", {}, sqlite3.OperationalError("no such table: jobs")), False),
        (OperationalError("", {}, psycopg.OperationalError("connection refused")), True),
        (InterfaceError("", {}, psycopg.InterfaceError("the connection is closed")), True),
        (ProgrammingError("", {}, psycopg.ProgrammingError("no such column")), False),
        (OSError(errno.ENOSPC, "no space left on device"), True),
        (FileNotFoundError("gone"), False),
        (ValueError("wrong"), False),
    ],
)
def test_an_outage_is_told_from_a_fault(error: Exception, outage: bool) -> None:
    assert is_outage(error) is outage


def failing(times: int, error: Exception) -> Callable[[int], int]:
    left = [error] * times

    def work(value: int) -> int:
        if left:
            raise left.pop()
        return value

    return work


def test_work_is_tried_anew_until_the_database_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outages, "wait_random_exponential", lambda **_: lambda _state: 0.0)
    assert patiently(failing(5, LOCKED), 3) == 3


def test_a_fault_is_not_tried_anew() -> None:
    with pytest.raises(ZeroDivisionError):
        patiently(failing(1, ZeroDivisionError()), 3)

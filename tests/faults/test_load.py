"""A class is not held back by one user's long jobs; `python -m tests.faults.load` has a hundred students."""

from pathlib import Path

import pytest

from tests.faults.load import LIMIT_WAIT, Load, observe


@pytest.fixture(autouse=True)
def _no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MODALLAB_KEY", raising=False)


def test_short_jobs_go_on_beside_queued_diagnoses(tmp_path: Path) -> None:
    seen = observe(Load(students=4, seconds=15.0, think=0.5, diagnoses=20), tmp_path)
    assert not seen.errors
    assert min(seen.loops) >= 1, seen.loops
    # Half of them: on a machine that others use, too, some wait for a process to start.
    assert seen.p(50, seen.waits) < LIMIT_WAIT
    assert seen.diagnosed < 10, "the diagnoses came first"

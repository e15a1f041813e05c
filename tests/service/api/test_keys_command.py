"""`modallab keys`: the first key of a service, while it runs or before."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from modallab_cli.app import app

Run = Callable[..., Result]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run `modallab keys` on a folder of the test's own."""
    monkeypatch.delenv("MODALLAB_DATABASE_URL", raising=False)

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(
            app, ["keys", *arguments, "--data", str(tmp_path / "new")], env={"COLUMNS": "200"}
        )

    return run


def create(run: Run, role: str, *more: str) -> tuple[str, str]:
    """Return id and text of a new key."""
    made = run("create", "--role", role, "--name", "Some Body", *more)
    assert made.exit_code == 0, made.output
    text = made.stdout.strip()
    form = re.fullmatch(r"modallab_([0-9a-f]{24})_[\w-]{43}", text)
    assert form is not None, "standard output has the key and nothing else"
    assert f"Key {form[1]} of Some Body, {role}" in made.stderr
    return form[1], text


def listed(run: Run) -> list[list[str]]:
    """Return id, role and state of all keys, newest first."""
    return [line.split()[:3] for line in run("list").stdout.splitlines()]


def test_keys_are_made_listed_renewed_and_revoked(run: Run) -> None:
    first, text = create(run, "admin")
    second, _ = create(run, "student", "--expires", "2001-01-01")
    assert listed(run) == [[second, "student", "expired"], [first, "admin", "valid"]]
    renewed = run("rotate", first).stdout.strip()
    assert renewed.split("_")[1] == first
    assert renewed != text
    assert run("revoke", first).exit_code == 0
    assert listed(run)[1] == [first, "admin", "revoked"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["create", "--role", "queen", "--name", "x"], "none of admin, instructor, student, service"),
        (["create", "--role", "student", "--name", "x"], "the first key is an administrator's"),
        (["create", "--role", "admin", "--name", ""], "1 to 100"),
        (["create", "--role", "admin", "--name", "x" * 101], "1 to 100"),
        (["revoke", "nothing"], "there is no key"),
        (["rotate", "nothing"], "there is no key"),
    ],
)
def test_what_cannot_be_is_refused_by_name(run: Run, arguments: list[str], said: str) -> None:
    result = run(*arguments)
    assert result.exit_code == 2
    assert said in result.stderr
    assert listed(run) == []

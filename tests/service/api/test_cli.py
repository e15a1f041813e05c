"""The command line: what it refuses, and what it prepares."""

import sqlite3
from pathlib import Path

import pytest
from click.testing import CliRunner

from modallab_cli.app import app

FIRST_KEY = ["keys", "create", "--role", "admin", "--name", "root"]


@pytest.fixture(autouse=True)
def no_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the settings of the shell out."""
    monkeypatch.delenv("MODALLAB_DATABASE_URL", raising=False)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["serve", "--role", "queen"], "role"),
        (["serve", "--port", "99999"], "port"),
        (["serve", "--role", "api"], "MODALLAB_DATABASE_URL"),
        (["worker"], "MODALLAB_DATABASE_URL"),
    ],
)
def test_settings_without_sense_are_refused_by_name(tmp_path: Path, arguments: list[str], said: str) -> None:
    result = CliRunner().invoke(app, [*arguments, "--data", str(tmp_path)], env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "lab.example"])
def test_an_address_that_others_reach_needs_keys(tmp_path: Path, host: str) -> None:
    arguments = ["serve", "--data", str(tmp_path), "--host", host]
    result = CliRunner().invoke(app, arguments, env={"COLUMNS": "300"})
    assert result.exit_code == 2
    assert f"others reach {host}, and there are no keys" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "environment", "has_keys"),
    [
        (["--host", "0.0.0.0", "--open"], {}, False),
        (["--host", "0.0.0.0"], {"MODALLAB_OPEN": "true"}, False),
        (["--host", "0.0.0.0"], {}, True),
        (["--host", "::1"], {}, False),
        ([], {}, False),
    ],
)
def test_an_address_is_served_that_is_safe_or_said_to_be_open(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    environment: dict[str, str],
    has_keys: bool,
) -> None:
    data, started = ["--data", str(tmp_path)], []
    monkeypatch.setattr("uvicorn.run", lambda *_, host, **__: started.append(host))
    monkeypatch.setattr("modallab.api.logs.configure", lambda: None)
    if has_keys:
        assert not CliRunner().invoke(app, [*FIRST_KEY, *data]).exit_code
    result = CliRunner().invoke(app, ["serve", *arguments, *data], env=environment)
    assert result.exit_code == 0, result.output
    assert started == [arguments[1] if arguments else "127.0.0.1"]


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    other = sqlite3.connect(tmp_path / "lock", isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    result = CliRunner().invoke(app, ["serve", "--data", str(tmp_path)], env={"COLUMNS": "200"})
    other.close()
    assert result.exit_code == 2
    assert "another service" in result.stderr


def test_init_prepares_the_tables(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["init", "--data", str(tmp_path)]).exit_code == 0
    tables = sqlite3.connect(tmp_path / "modallab.sqlite")
    found = {name for (name,) in tables.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    tables.close()
    assert {"things", "links", "truths", "jobs"} <= found

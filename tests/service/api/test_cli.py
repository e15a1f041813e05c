"""The command line: what it refuses, and what it prepares."""

import sqlite3
from pathlib import Path

import pytest
from click.testing import CliRunner

from modallab_cli.app import app


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

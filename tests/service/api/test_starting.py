"""A start that cannot succeed says why in one sentence, and ends with its own exit code."""

import os
import resource
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from modallab.api.settings import ServiceSettings
from modallab.store.place import engine_of
from modallab_cli.starting import UNUSABLE


def start(data: Path, *, largest_file: int | None = None) -> subprocess.CompletedProcess[str]:
    """Return what became of `modallab init` in a folder."""

    def limit() -> None:
        if largest_file is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    clean = {name: value for name, value in os.environ.items() if not name.startswith("MODALLAB_")}
    command = [sys.executable, "-m", "modallab", "init", "--data", str(data)]
    return subprocess.run(command, env=clean, capture_output=True, text=True, timeout=60, preexec_fn=limit)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Folder of a lab that has run before."""
    settings = ServiceSettings(data=tmp_path)
    settings.store_place.prepare()
    engine_of(settings.store_place).dispose()  # what it wrote is then in the file itself
    return tmp_path


def told(run: subprocess.CompletedProcess[str]) -> str:
    assert run.returncode == UNUSABLE, run.stderr
    (line,) = run.stderr.splitlines()  # no traceback
    return line


def test_a_damaged_database_is_told(data: Path) -> None:
    file = data / "modallab.sqlite"
    content = bytearray(file.read_bytes())
    content[4096:12288] = b"\xff" * 8192
    file.write_bytes(bytes(content))
    assert "modallab.sqlite is damaged" in told(start(data))
    file.write_bytes(b"no database at all" * 100)
    assert "modallab.sqlite is damaged" in told(start(data))


def test_a_later_schema_is_told(data: Path) -> None:
    with closing(sqlite3.connect(data / "modallab.sqlite")) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
        connection.commit()
    assert "later version" in told(start(data))


def test_a_full_disk_is_told(tmp_path: Path) -> None:
    """A limit on the size of files stands for a full disk, which needs rights to make."""
    assert "cannot be used" in told(start(tmp_path, largest_file=1000))


def test_a_folder_that_cannot_be_written_is_told() -> None:
    assert "cannot be used" in told(start(Path("/proc/modallab")))

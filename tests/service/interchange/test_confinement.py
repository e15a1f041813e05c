"""Limits of the process that reads files: they are for the files, not for the program itself."""

import io
from dataclasses import replace
from pathlib import Path

import pytest

from modallab.core.errors import InvalidInputError
from modallab.interchange import confinement
from modallab.interchange.confinement import NamedFile, run_confined
from modallab.interchange.settings import CONFINEMENT

# A program that takes processor time as it begins, as imports do on a slow machine, and as it reads.
PROGRAM = """
import sys, time
from modallab.interchange.reader_process import answer

def work(seconds):
    while time.process_time() < seconds + begin:
        pass

def read(folder, request):
    global begin
    begin = time.process_time()
    work(request["reading"])
    return {"bytes": len((folder / "0").read_bytes())}, {}

begin = 0.0
work(request_of_start)
answer(sys.argv[1], read)
"""


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a program of 3 s of processor time before it reads, where a file has 1 s."""
    (tmp_path / "busy_reader.py").write_text(PROGRAM.replace("request_of_start", "3.0"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(confinement, "CONFINEMENT", replace(CONFINEMENT, processor_seconds=1))
    return "busy_reader"


def test_a_slow_start_is_no_fault_of_the_file(program: str) -> None:
    about, _ = run_confined(program, [NamedFile("f", io.BytesIO(b"four"))], {"reading": 0.1}, largest=100)
    assert about == {"bytes": 4}


def test_a_file_that_takes_too_long_is_refused_for_that(program: str) -> None:
    with pytest.raises(InvalidInputError, match="takes too long to read"):
        run_confined(program, [NamedFile("f", io.BytesIO(b"four"))], {"reading": 60.0}, largest=100)

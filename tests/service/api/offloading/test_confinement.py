"""A worker process that takes too much memory ends before it harms anything else."""

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import sys, time
from dataclasses import replace
from pathlib import Path
import numpy as np
from modallab.api.offloading import confinement
confinement.OFFLOADING = replace(confinement.OFFLOADING, {limit})
with confinement.confined(Path(sys.argv[1])):
    kept = [np.ones(2_500_000) for _ in range(20)]  # 400 MB
    end = time.process_time() + 1.0
    while time.process_time() < end:
        pass
print("survived")
"""


@pytest.mark.parametrize(
    ("limit", "survives"),
    [
        ("resident_bytes=300_000_000", False),
        ("data_bytes=300_000_000", False),
        ("processor_seconds=0.5", False),
        ("resident_bytes=10**9", True),
    ],
)
def test_memory_and_time_are_limited(tmp_path: Path, limit: str, survives: bool) -> None:
    program = [sys.executable, "-c", PROGRAM.format(limit=limit), str(tmp_path)]
    run = subprocess.run(program, capture_output=True, text=True, timeout=60)
    assert (run.stdout == "survived\n") is survives
    assert (run.returncode == 0) is survives

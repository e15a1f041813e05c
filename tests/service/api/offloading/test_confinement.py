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
    time.sleep(1.0)
print("survived")
"""


@pytest.mark.parametrize(
    ("limit", "survives"),
    [
        ("resident_bytes=300_000_000", False),
        ("data_bytes=300_000_000", False),
        ("resident_bytes=10**9", True),
    ],
)
def test_memory_is_limited(tmp_path: Path, limit: str, survives: bool) -> None:
    program = [sys.executable, "-c", PROGRAM.format(limit=limit), str(tmp_path)]
    run = subprocess.run(program, capture_output=True, text=True, timeout=60)
    assert (run.stdout == "survived\n") is survives
    assert (run.returncode == 0) is survives

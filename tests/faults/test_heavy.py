"""Requests that cost much from little: answered within limits of time and memory, and nobody else waits."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.faults.heavy import CASES, LEAST_HEALTH, LIMIT_HEALTH, Observation, observe
from tests.serving import Lab, free_port, running

# The others take half a minute of processor time together: `python -m tests.faults.heavy` has them.
SHORT = (
    "abaqus",
    "vtk",
    "gmsh",
    "ten npz of 199 MB",
    "45 times the modes of a plate of 60 x 60",
    "one plate of 200 x 200",
)
# s, a request that hangs; the limit of 10 s is for a quiet computer, and judged by that script.
HANGS = 60.0
HEALTH: list[float] = []  # s, of all cases: one alone has too few requests for a percentile
Served = tuple[Lab, int, int]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A service, its port and its process."""
    port = free_port()
    data = tmp_path_factory.mktemp("heavy")
    with running("serve", "--port", str(port), data=data) as service, Lab(port) as lab:
        lab.wait_until_up()
        yield lab, port, service.pid


@pytest.mark.parametrize("case", SHORT)
def test_a_heavy_request_harms_nobody(served: Served, case: str) -> None:
    assert case in CASES
    seen = observe(*served, case)
    HEALTH.extend(seen.health)
    assert not replace(seen, health=[]).faults(HANGS), seen.statuses


def test_health_is_told_meanwhile() -> None:
    together = Observation(health=HEALTH)
    assert len(HEALTH) >= LEAST_HEALTH
    assert together.health_p99 <= LIMIT_HEALTH

"""Jobs end by themselves, with the same results, whatever befalls what runs them; one moment a fault."""

import time
from collections.abc import Iterator
from contextlib import nullcontext

import pytest

from tests.faults.__main__ import disturbed
from tests.faults.faults import FAULTS, ON_A_SMALL_DISK
from tests.faults.site import BESIDE_OTHERS, Question, Site, may_mount, questions, site, small_disk

LONG = ("away for 45 s", "away for 120 s")  # `python -m tests.faults` has these too
Ready = tuple[Site, list[Question], list[object]]


@pytest.fixture(scope="module", params=FAULTS)
def ready(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ready]:
    """A site, and what its jobs find undisturbed."""
    data = tmp_path_factory.mktemp("faults")
    with small_disk(data) if may_mount() else nullcontext(), site(request.param, data) as place:
        asked = questions(place.lab)
        yield place, asked, [q.result(place.lab, q.start(place.lab), BESIDE_OTHERS) for q in asked]


@pytest.mark.parametrize("name", dict.fromkeys(name for faults in FAULTS.values() for name in faults))
def test_a_disturbed_job_ends_with_the_same_result(ready: Ready, name: str) -> None:
    place, asked, expected = ready
    fault = FAULTS["postgresql" if place.gate else "sqlite"].get(name)
    if fault is None or name.endswith(LONG):
        pytest.skip("of the other database, or too long for the suite")
    if name == ON_A_SMALL_DISK and not may_mount():
        pytest.skip("no file system may be mounted here")
    while place.gate and len(place.hosts) < 2:
        place.start_host()
    i = sum(map(ord, name)) % len(asked)
    found, _ = disturbed(place, asked[i], fault, 0.6, BESIDE_OTHERS)
    place.hosts[:] = [host for host in place.hosts if host.poll() is None]
    assert found == expected[i]


def test_book_and_engine_agree_in_the_end(ready: Ready) -> None:
    end = time.monotonic() + 20
    while ready[0].unfinished() != (0, 0) and time.monotonic() < end:
        time.sleep(0.2)
    assert ready[0].unfinished() == (0, 0)


def test_every_result_is_stored_once_and_whole(ready: Ready) -> None:
    """What the questions need is stored beside the results of jobs, and nothing else."""
    assert ready[0].not_results() == {"structure": 3, "rig": 1, "modal_model": 1, "part": 0}

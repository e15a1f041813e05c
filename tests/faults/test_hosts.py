"""A job of a host that is cut off ends on another: `tests.faults.hosts` in short."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.faults.hosts import CUTS, Pair, cut_off, pair
from tests.faults.network import lacking
from tests.faults.site import BESIDE_OTHERS


@pytest.fixture(scope="module")
def two_hosts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    """Two hosts that share a database server and a folder."""
    if (reason := lacking()) is not None:
        pytest.skip(f"NO HOST CUT OFF: {reason}")
    with pair(Path(tmp_path_factory.mktemp("hosts")), BESIDE_OTHERS) as place:
        yield place


@pytest.mark.parametrize("cut", CUTS)
def test_the_job_of_a_host_that_is_cut_off_ends_on_the_other(two_hosts: Pair, cut: str) -> None:
    expected = two_hosts.undisturbed()
    outcome = cut_off(two_hosts, CUTS[cut], 0.1)
    assert outcome.found == expected
    assert outcome.again == expected
    assert two_hosts.stored() == (two_hosts.jobs, 0, 0)

"""Settings of the whole suite."""

from itertools import chain, groupby, zip_longest

import pytest
from hypothesis import settings

# What is imported at its first use may take longer than hypothesis allows an example; no test is timed here.
current = settings.get_profile(settings.get_current_profile_name())
settings.register_profile("untimed", parent=current, deadline=None)
settings.load_profile("untimed")

# Their tests start processes, and wait for these half of the time.
WAITING = (
    "benchmarks",
    "client",
    "docker",
    "docs",
    "end_to_end",
    "faults",
    "generators",
    "page",
    "service/api",
    "service/jobs",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let files whose tests wait alternate with those that compute: several workers then share the cores."""
    files = [list(tests) for _, tests in groupby(items, key=lambda item: item.path)]
    waiting = [tests for tests in files if _waits(tests[0].nodeid)]
    computing = [tests for tests in files if not _waits(tests[0].nodeid)]
    # As many computing files after each waiting one as there are in all.
    share = max(1, len(computing) // max(1, len(waiting)))
    blocks = [list(chain.from_iterable(computing[i : i + share])) for i in range(0, len(computing), share)]
    pairs = zip_longest(waiting, blocks, fillvalue=list[pytest.Item]())
    items[:] = chain.from_iterable(chain.from_iterable(pairs))


def _waits(node: str) -> bool:
    place = node.removeprefix("tests/")
    return place.startswith(tuple(f"{room}/" for room in WAITING))

"""Settings of the whole suite."""

from itertools import chain, groupby, zip_longest

import pytest
from hypothesis import settings

# What is imported at its first use may take longer than hypothesis allows an example; no test is timed here.
current = settings.get_profile(settings.get_current_profile_name())
settings.register_profile("untimed", parent=current, deadline=None)
settings.load_profile("untimed")

# Their tests start processes, and wait for these half of the time; folders of the longest files come first.
WAITING = (
    "faults",
    "service/jobs",
    "end_to_end",
    "page",
    "benchmarks",
    "docs",
    "client",
    "docker",
    "generators",
    "service/api",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let files whose tests wait alternate with those that compute: several workers then share the cores."""
    files = [list(tests) for _, tests in groupby(items, key=lambda item: item.path)]
    waiting = sorted((tests for tests in files if _rank(tests) < len(WAITING)), key=_rank)
    computing = [tests for tests in files if _rank(tests) == len(WAITING)]
    # As many computing files after each waiting one as there are in all.
    share = max(1, len(computing) // max(1, len(waiting)))
    blocks = [list(chain.from_iterable(computing[i : i + share])) for i in range(0, len(computing), share)]
    pairs = zip_longest(waiting, blocks, fillvalue=list[pytest.Item]())
    items[:] = chain.from_iterable(chain.from_iterable(pairs))


def _rank(tests: list[pytest.Item]) -> int:
    """Return the number of the folder of a file among those whose tests wait; after them, of all others."""
    place = tests[0].nodeid.removeprefix("tests/")
    return next((i for i, folder in enumerate(WAITING) if place.startswith(f"{folder}/")), len(WAITING))

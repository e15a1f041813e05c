"""What can be stored elsewhere: all that is the owner's and was made from what is."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.store.base import Description, Truth
from modallab.store.npz import unpack
from modallab.store.sql import SqlStore
from tests.service.store.test_sql import BEAM, RIG, measurement


def exported(store: SqlStore, owner: str = "me", label: str | None = None) -> tuple[list[str], set[str]]:
    """Return the ids of what can be exported in order, and of what cannot."""
    found = store.projects.contents(owner=owner, label=label)
    return [entry.id for entry in found.entries], set(found.left_out)


def test_each_comes_after_what_it_was_made_from_whenever_it_was_published(store: SqlStore) -> None:
    rig = store.rigs.add(RIG, owner="unpublished")
    test = store.measurements.add(measurement(), owner="me", inputs={"rig_id": rig})
    assert exported(store) == ([], {test})  # the rig is not the owner's yet
    store.rigs.hand_over(rig, owner="me", created="2100-01-01")
    assert exported(store) == ([rig, test], set())


def test_what_was_made_from_what_stays_stays_too(store: SqlStore) -> None:
    shared = store.structures.add(BEAM, owner="instructor")
    changed = store.structures.add(BEAM, owner="me", inputs={"structure_id": shared})
    again = store.structures.add(BEAM, owner="me", inputs={"structure_id": changed})
    own = store.structures.add(BEAM, owner="me")
    assert exported(store) == ([own], {changed, again})
    store.structures.discard(own)
    assert exported(store) == ([], {changed, again})


def test_a_label_brings_all_origins_and_nothing_else(store: SqlStore) -> None:
    rigs = [store.rigs.add(RIG, owner="me") for _ in range(2)]
    tests = [store.measurements.add(measurement(), owner="me", inputs={"rig_id": rig}) for rig in rigs]
    store.measurements.describe(tests[1], Description(labels=["autumn"]))
    assert exported(store, label="autumn") == ([rigs[1], tests[1]], set())
    assert exported(store, label="autum") == ([], set())


def test_parts_are_those_of_the_store_without_the_truth(store: SqlStore) -> None:
    beam = store.structures.add(BEAM, owner="me", request={"kind": "beam"})
    test = store.measurements.add(measurement(), owner="me")
    store.truths.add(Truth(beam, ()), measurement_id=test, owner="me")
    parts = store.projects.parts(test)
    assert parts.arrays == store.measurements.npz(test)
    assert unpack(parts.arrays)["averages"] == 94.8
    assert beam not in str(parts.body)
    assert (parts.request, store.projects.parts(beam).request) == (None, {"kind": "beam"})


def test_what_is_removed_meanwhile_is_told(store: SqlStore) -> None:
    rig = store.rigs.add(RIG, owner="me")
    store.rigs.discard(rig)
    with pytest.raises(InvalidInputError, match="removed while it was written"):
        store.projects.parts(rig)

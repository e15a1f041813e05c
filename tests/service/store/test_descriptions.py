"""Descriptions: stored, and found by whole labels and parts of names, in every database."""

from modallab.core.dof import Dof
from modallab.rig.setup import RigSetup
from modallab.store.base import Description
from modallab.store.sql import SqlStore

RIG = RigSetup(drives=(Dof(1, "Y"),), responses=(Dof(1, "Y"),))


def test_entries_are_found_by_their_descriptions(store: SqlStore) -> None:
    first, second = (store.rigs.add(RIG, owner="me") for _ in range(2))
    store.rigs.describe(first, Description("First", ['group "3"', "über"], "a remark"))
    store.rigs.describe(second, Description(labels=["group"]))
    store.rigs.describe(first, Description())
    entry = store.rigs.entry(first)
    assert (entry.name, entry.labels, entry.comment) == ("First", ['group "3"', "über"], "a remark")
    found = {label: [e.id for e in store.rigs.list(label=label, limit=9)] for label in ("group", "über", "g")}
    assert found == {"group": [second], "über": [first], "g": []}
    assert [e.id for e in store.rigs.list(name="IRS", limit=9)] == [first]
    assert store.rigs.list(name="%", limit=9) == []

"""Dataclasses to JSON and back, by their annotations and no further."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import FloatArray
from modallab.store.base import StoredDataError
from modallab.store.plain import from_plain, to_plain


class Colour(StrEnum):
    RED = "red"


@dataclass(frozen=True)
class Leaf:
    number: float
    name: str = ""


@dataclass(frozen=True)
class Other:
    number: float


@dataclass(frozen=True, eq=False)
class Tree:
    leaves: tuple[Leaf | Other | None, ...]
    pair: tuple[int, bool]
    by_number: Mapping[int, Leaf]
    by_name: Mapping[str, float]
    colour: Colour
    mode: Literal["a", "b"]
    weight: complex
    array: FloatArray | None = None


def back(value: Any) -> Any:
    tree, arrays = to_plain(value)
    return from_plain(type(value), json.loads(json.dumps(tree, allow_nan=False)), arrays)


def test_a_tree_of_everything_comes_back() -> None:
    tree = Tree(
        leaves=(Leaf(1.0, "x"), Other(2.0), None),
        pair=(3, True),
        by_number={7: Leaf(float("inf"))},
        by_name={"a": 0.1},
        colour=Colour.RED,
        mode="b",
        weight=1 - 2j,
        array=np.array([1.0, np.nan]),
    )
    found = back(tree)
    assert found.leaves == tree.leaves
    assert (found.pair, found.by_number, found.by_name) == (tree.pair, tree.by_number, tree.by_name)
    assert (found.colour, found.mode, found.weight) == (Colour.RED, "b", 1 - 2j)
    np.testing.assert_array_equal(found.array, tree.array)


@settings(deadline=None, max_examples=50)
@given(st.builds(Leaf, st.floats(allow_nan=False), st.text()))
def test_numbers_and_names_keep_every_bit(leaf: Leaf) -> None:
    assert back(leaf) == leaf


@pytest.mark.parametrize(
    "tree",
    [
        {"$type": "Other", "number": 1.0},
        {"$type": "Leaf", "number": "1.0"},
        {"$type": "Leaf", "number": True},
        {"$type": "Leaf", "number": 1.0, "extra": 1},
        {"number": 1.0},
        [],
    ],
)
def test_what_does_not_fit_the_type_is_refused(tree: Any) -> None:
    with pytest.raises(StoredDataError):
        from_plain(Leaf, tree, {})


def test_a_value_that_does_not_fit_is_named_by_its_path() -> None:
    tree, arrays = to_plain(Tree((Leaf(1.0),), (3, True), {}, {"a": 0.1}, Colour.RED, "a", 1j))
    tree["pair"] = [3, "yes"]
    with pytest.raises(StoredDataError, match=r"Tree\.pair\.1 is not") as refused:
        from_plain(Tree, tree, arrays)
    assert refused.value.context["field"] == "Tree.pair.1"


def test_what_has_no_plain_form_is_refused() -> None:
    with pytest.raises(TypeError, match="object"):
        to_plain(object())

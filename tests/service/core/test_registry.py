"""A family reads like a dictionary and fills itself."""

import sys
import types

import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.registry import Family


def family(monkeypatch: pytest.MonkeyPatch) -> Family[int]:
    monkeypatch.setitem(sys.modules, "nowhere_in_particular", types.ModuleType("nowhere_in_particular"))
    numbers: Family[int] = Family("number", home="nowhere_in_particular")
    numbers.register("two")(2)
    numbers.register("one")(1)
    return numbers


def test_members_are_found_by_name_in_alphabetical_order(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers = family(monkeypatch)
    assert list(numbers) == ["one", "two"]
    assert (len(numbers), numbers["two"], "three" in numbers) == (2, 2, False)


def test_an_unknown_name_is_refused_with_those_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidInputError) as caught:
        family(monkeypatch)["three"]
    assert caught.value.context == {"field": "number", "value": "three", "allowed": ["one", "two"]}


def test_a_name_taken_cannot_be_taken_again(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RuntimeError, match="twice"):
        family(monkeypatch).register("one")(11)

"""Errors carry values of JSON, and one function puts them into a sentence."""

import json
from typing import Any

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds, in_words, sentence

WORDS: list[tuple[Any, str]] = [
    (bounds(1, 6), "1 to 6"),
    (bounds(4, unit="modes"), "at least 4 modes"),
    (bounds(maximum=2.5, unit="s"), "at most 2.5 s"),
    (bounds(exclusive_minimum=0, unit="Hz"), "more than 0 Hz"),
    (bounds(exclusive_minimum=0, maximum=1.0), "more than 0 and at most 1"),
    (bounds(exclusive_maximum=1e12, unit="1"), "less than 1e+12"),
    ({"nodes": bounds(1, 4)}, "nodes: 1 to 4"),
    (["lscf", "dobson"], "lscf, dobson"),
    ([], "none"),
    (None, "null"),
    (40, "40"),
    ("each once", "each once"),
]


@pytest.mark.parametrize(("value", "words"), WORDS)
def test_values_allowed_are_put_into_words(value: Any, words: str) -> None:
    assert in_words(value) == words


def test_a_sentence_names_the_field_its_value_and_the_values_allowed() -> None:
    error = InvalidInputError("too many modes", field="n_modes", value=7, allowed=bounds(1, 6))
    assert sentence(error) == "too many modes (field: n_modes; value: 7; allowed: 1 to 6)"
    assert str(error) == "too many modes"
    assert sentence(InvalidInputError("nothing to do")) == "nothing to do"


def test_the_context_is_json() -> None:
    numbers: Any = (np.int64(3), np.float64(0.5), float("nan"))
    dof: Any = Dof.parse("5:+Y")
    error = InvalidInputError("wrong", field="dofs", value=numbers, allowed={"at": dof, "free": True})
    assert error.context["value"] == [3, 0.5, "nan"]
    assert json.loads(json.dumps(error.context, allow_nan=False)) == error.context
    assert error.context["allowed"] == {"at": "5:+Y", "free": True}

"""What a request may drop and merge."""

from typing import Any

import pytest

from modallab.core.errors import InvalidInputError
from modallab.extraction.requested.selection import ModeSelection


def test_every_mode_is_kept_dropped_or_merged_once() -> None:
    selection = ModeSelection(drop=(2,), merge=((5, 3),))
    assert selection.groups(6) == [(0,), (2, 4), (3,), (5,)]
    assert selection.words == "dropped 2; merged 3 and 5"


@pytest.mark.parametrize(
    ("asked", "field", "value"),
    [
        ({}, "drop", []),
        ({"drop": (7,)}, "drop", 7),
        ({"drop": (0,)}, "drop", 0),
        ({"merge": ((1, 9),)}, "merge", 9),
        ({"merge": ((1,),)}, "merge", [1]),
        ({"merge": ((1, 1),)}, "merge", [1, 1]),
        ({"drop": (1,), "merge": ((1, 2),)}, "merge", 1),
        ({"merge": ((1, 2), (2, 3))}, "merge", 2),
        ({"drop": (3, 3)}, "merge", 3),
        ({"drop": (1, 2, 3, 4, 5, 6)}, "drop", [1, 2, 3, 4, 5, 6]),
    ],
)
def test_numbers_that_mean_nothing_are_refused_by_name(asked: dict[str, Any], field: str, value: Any) -> None:
    with pytest.raises(InvalidInputError) as caught:
        ModeSelection(**asked).groups(6)
    assert (caught.value.context["field"], caught.value.context["value"]) == (field, value)
    assert caught.value.context["allowed"]

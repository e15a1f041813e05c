"""Places in words, as summaries of results have them."""

from typing import Any

import pytest

from modallab_client.methods.diagnoses import effect_name, place

CHANNELS = [f"{node}:+Y" for node in range(1, 12)]


@pytest.mark.parametrize(
    ("at", "words"),
    [
        (None, "everywhere"),
        ("7:+Y", "7:+Y"),
        ({"members": [3]}, "member 3"),
        ({"members": [3, 4, 5, 6, 7]}, "members 3, 4, 5, 6, 7"),  # numbers of members are never left out
        ({"channels": CHANNELS[:2]}, "channels 1:+Y, 2:+Y"),
        ({"channels": CHANNELS}, "11 channels, 1:+Y to 11:+Y"),
    ],
)
def test_a_place_in_words(at: Any, words: str) -> None:
    assert place(at) == words


def test_an_effect_everywhere_has_no_place() -> None:
    assert effect_name("gain_error", None) == "gain error"

"""Degrees of freedom in the names and headers of other programs."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.interchange.file_content import Piece
from modallab.interchange.format import read_pieces
from modallab.interchange.points import dofs_in
from modallab.interchange.reading_options import ReadingOptions

NAMES = {"a": "1:+Y", "b1": "2:+Y", "b10": "3:+Y", "tail": "4:+Y"}


@pytest.mark.parametrize(
    ("label", "found"),
    [
        ("Response: tail Force: tail", ["4:+Y", "4:+Y"]),  # the drive point, at both ends
        ("Response: b10 Force: b1", ["3:+Y", "2:+Y"]),
        ("real a", ["1:+Y"]),  # no letter of another word
        ("frf_tail_b1.csv", ["4:+Y", "2:+Y"]),
        ("tail:-Z / a", ["4:-Z", "1:+Y"]),
    ],
)
def test_names_of_points_are_found_as_whole_words(label: str, found: list[str]) -> None:
    assert [str(dof) for dof in dofs_in(label, NAMES)] == found


def text(response: str, force: str, last: str = "0.98765") -> Piece:
    rows = [f"{f}.0;1.0;-0.5;{last if f == 5 else '0.98765'}" for f in range(1, 9)]
    lines = [f"Response: {response}", f"Force: {force}", "Freq [Hz];Real;Imag;Coherence", *rows]
    return Piece(f"{force}.csv", "\n".join(lines).encode(), 1)


def test_an_frf_that_no_file_holds_is_named() -> None:
    files = [text("tail", "a"), text("tail", "b1"), text("b10", "b1")]
    with pytest.raises(InvalidInputError, match=r"1 are missing, such as 3:\+Y / 1:\+Y"):
        read_pieces(files, ReadingOptions(map=NAMES), largest=10_000)

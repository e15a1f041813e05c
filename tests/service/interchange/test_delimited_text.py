"""Numbers of few digits in delimited text."""

import numpy as np
import pytest

from modallab.interchange.file_content import Piece
from modallab.interchange.format import read_pieces
from modallab.interchange.reading_options import NO_OPTIONS


def coherence_of(*texts: str) -> np.ndarray:
    rows = [f"{f}.0,1.0,-0.5,{texts[f % len(texts)]}" for f in range(1, 13)]
    piece = Piece("frf.csv", "\n".join(["freq,real,imag,coherence", *rows]).encode(), 1)
    coherence = read_pieces([piece], NO_OPTIONS, largest=10_000).coherence
    assert coherence is not None
    return coherence


def test_a_coherence_that_a_text_rounds_to_one_is_the_mean_of_what_is_rounded() -> None:
    # five digits: 0.999995 to 1 are written as 1; exactly 1 would have no random error at all
    assert coherence_of("0.98765", "1.00000").max() == pytest.approx(1 - 2.5e-6, abs=1e-12)


@pytest.mark.parametrize("texts", [("1.0",), ("0.9", "0.123456789")])
def test_other_coherence_stays_as_it_is(texts: tuple[str, ...]) -> None:
    assert coherence_of(*texts).max() == max(map(float, texts))

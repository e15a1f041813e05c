"""Several forces that leak come with a warning."""

import numpy as np
import pytest

from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.leakage import WindowLeakage
from tests.service.extraction.several_references import AVERAGES, driven

LEAKAGE = WindowLeakage.from_window(np.hanning(513)[:512], "h1", source_mass=0.1)


@pytest.mark.parametrize(
    ("drives", "leakage", "warned"), [((0, 1), LEAKAGE, True), ((0, 1), None, False), ((0,), LEAKAGE, False)]
)
def test_leakage_of_several_forces_is_said_to_be_undone_as_if_they_were_white(
    drives: tuple[int, ...], leakage: WindowLeakage | None, warned: bool
) -> None:
    made = driven(12.0, drives)
    model = extract(made.frf, coherence=made.coherence, averages=AVERAGES, leakage=leakage)
    assert (
        any(note.startswith("leakage with 2 references is corrected as if") for note in model.notes) == warned
    )

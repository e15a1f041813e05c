"""The verdict in one sentence."""

from dataclasses import replace

import pytest

from modallab.diagnosis.reporting.verdict_text import headline
from modallab.diagnosis.result import Verdict
from tests.diagnosed import STEP, diagnosis


@pytest.mark.parametrize(
    ("gap_after", "words"), [(1.5, "what remains, 2.5 % of it,"), (0.99, "what remains, in the FRFs,")]
)
def test_what_remains_is_a_share_of_the_gap_or_a_part_of_the_data(gap_after: float, words: str) -> None:
    # Fitted data without a gap: what remains is in those held out, and no share of the gap before.
    step = replace(STEP, gap_before=21.0, gap_after=gap_after)
    found = diagnosis(Verdict.PARTLY_EXPLAINED, (step,))
    found = replace(found, gaps={"before": {"frf": 30.0, "force": 1.0}, "after": {"frf": 1.2, "force": 1.0}})
    assert words in headline(found)

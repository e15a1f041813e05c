"""Whatever is sent with keys is answered as the document says: `tests.faults.documented` in short."""

from pathlib import Path

import pytest

from tests.faults.documented import Tally, in_turn, school_of
from tests.service.api.test_authorisation import OPERATIONS


@pytest.mark.parametrize("kind", ["sqlite"])  # the script has the other database
def test_every_answer_is_documented_and_none_is_a_fault(kind: str, tmp_path: Path) -> None:
    with school_of(kind, tmp_path) as (school, address):
        for caller in ("instructor", "student"):
            tally = Tally()
            for _ in in_turn(school, caller, address, tally, turn=0, examples=1):
                pass
            assert not tally.faults, "\n".join(f"{name}\n{text}" for name, text in tally.faults.items())
            assert tally.operations == {f"{method} {path}" for method, path in OPERATIONS.values()}

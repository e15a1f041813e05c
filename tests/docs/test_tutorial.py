"""What docs/tutorial.md tells to type."""

from pathlib import Path
from typing import Any

from tests.pages import run_page


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what the page says."""
    assert names["update"].suspected["stiffness"] == (11, 12)
    (step,) = names["found"].steps
    assert (names["found"].verdict, step.effect.kind) == ("explained", "stiffness_error")
    factor = step.effect.parameters["factor"]
    # five standard errors: one run in two million is further off by chance
    assert abs(factor.value - 1.4) < 5 * factor.standard_error
    for picture in ("measured.png", "found.png"):
        assert Path(picture).stat().st_size > 10_000  # bytes of a picture with curves; an empty one has 5,000
    stages = names["update"].frequencies
    pairs = zip(stages["before"], stages["measured"], strict=True)
    differences = [abs(measured / model - 1) for model, measured in pairs]
    assert 0.035 <= round(max(differences), 3) < 0.045  # the page says 4 %


def test_the_examples_run_and_give_what_the_page_says(tmp_path: Path) -> None:
    run_page("tutorial.md", tmp_path, check)

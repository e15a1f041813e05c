import numpy as np

from modallab.extraction.options import Damping, DistantLinesOptions, SingleModeOptions
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.single_mode.plan import choice_value, plan

OPEN, OPEN_NEAR = DistantLinesOptions(), SingleModeOptions()


def leaked_by(estimator: str) -> WindowLeakage:
    return WindowLeakage.from_window(np.hanning(513)[:512], estimator)


def test_what_leaks_is_read_from_more_lines_and_the_choice_says_why() -> None:
    periodic, leaked = plan(OPEN, None), plan(OPEN, leaked_by("h2"))
    assert (periodic.lines, leaked.lines) == (8, 12)
    assert "no leakage" in periodic.choices["lines"]
    assert "with leakage" in leaked.choices["lines"]
    assert "h2" in leaked.choices["leave_out"]
    assert choice_value(leaked.choices, "lines") == "12"
    assert choice_value(leaked.choices, "leave_out") == "0"


def test_of_leaked_h1_the_nearest_lines_are_left_out_by_the_methods_that_can() -> None:
    able, unable = plan(OPEN, leaked_by("h1")), plan(OPEN_NEAR, leaked_by("h1"))
    assert (able.lines, able.leave_out) == (16, 4)  # as many as of H2 are left
    assert "least certain" in able.choices["leave_out"]
    assert (unable.lines, unable.leave_out) == (12, 0)
    few = plan(DistantLinesOptions(lines=9), leaked_by("h1"))
    assert (few.lines, few.leave_out) == (9, 1)  # eight stay, as many as of periodic data


def test_what_the_user_decides_is_kept_to_the_line() -> None:
    asked = plan(DistantLinesOptions(lines=20, leave_out=3, damping=Damping.VISCOUS), None)
    assert (asked.lines, asked.leave_out, asked.widths) == (20, 3, 0.0)
    assert asked.choices == {
        "lines": "20: as requested",
        "leave_out": "3: as requested",
        "damping": "viscous: as requested",
    }
    assert choice_value(asked.choices, "order") is None


def test_lines_left_out_are_made_up_for_where_their_number_is_open() -> None:
    assert plan(DistantLinesOptions(leave_out=4), None).lines == 12

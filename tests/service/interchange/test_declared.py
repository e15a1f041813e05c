"""What is declared of a test beside its files, and what is assumed of the rest."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.declared import DeclaredTest
from modallab.interchange.measured import MeasuredFile
from tests.rigs import rig

FREQ = np.arange(0.0, 50.0)
HERE = Dof(1, "Y")


def measured(declared: DeclaredTest) -> dict[str, str]:
    """Return what is assumed of a file without a rig, by quantity."""
    values = 1 / ((2 * np.pi * 20.0) ** 2 * (1 + 0.02j) - (2 * np.pi * FREQ) ** 2)
    frf = FrfSet(FREQ, values[:, None, None].astype(complex), (HERE,), (HERE,), FrfKind.RECEPTANCE)
    test = MeasuredFile(frf, averages=5.0).without_log_book(declared)
    window = test.setup.analyser.line_window
    assert window.end == (declared.window_end or (0.01 if declared.window == "exponential" else 1.0))
    return {assumption.quantity: assumption.value for assumption in test.assumed}


def test_the_source_of_a_test_without_a_log_book_is_assumed() -> None:
    assert measured(DeclaredTest())["excitation"] == "periodic_random"


def test_the_end_of_a_window_is_assumed_unless_it_is_declared() -> None:
    assert measured(DeclaredTest(window="exponential"))["window_end"] == "0.01"
    assert "window_end" not in measured(DeclaredTest(window="exponential", window_end=0.2))
    assert "window_end" not in measured(DeclaredTest())


@pytest.mark.parametrize("declared", [DeclaredTest(window_end=0.1), DeclaredTest(None, None, "hann", 0.1)])
def test_only_a_window_that_decays_has_an_end(declared: DeclaredTest) -> None:
    with pytest.raises(InvalidInputError) as caught:
        measured(declared)
    assert caught.value.context["field"] == "window_end"
    with pytest.raises(InvalidInputError) as caught:
        declared.check_against(rig(3))
    assert caught.value.context["field"] == "window_end"


def test_an_end_of_a_window_agrees_with_the_rig() -> None:
    setup = rig(3, analyser={"window": "exponential", "window_end": 0.3})
    DeclaredTest(window_end=0.3).check_against(setup)
    with pytest.raises(InvalidInputError) as caught:
        DeclaredTest(window_end=0.2).check_against(setup)
    assert caught.value.context["allowed"] == [0.3]


@pytest.mark.parametrize("end", [0.0, 1.0, float("nan")])
def test_an_end_out_of_bounds_is_refused(end: float) -> None:
    with pytest.raises(InvalidInputError) as caught:
        DeclaredTest(window="exponential", window_end=end)
    assert caught.value.context["field"] == "window_end"

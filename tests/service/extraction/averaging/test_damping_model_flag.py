import numpy as np
import pytest

from modallab.core.modal_model import Mode
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping
from tests.service.extraction.conftest import Beam
from tests.service.extraction.six_mode_models import six_mode_model
from tests.service.extraction.test_extract import noise_of
from tests.synthetic import six_modes


def law_flag(mode: Mode) -> float | None:
    """Return by how many Hz a mode's frequency is said to be higher; None if nothing is said."""
    said = [flag for flag in mode.flags if flag.startswith("damping_law: frequency ")]
    return float(said[0].split()[2]) if said else None


@pytest.mark.parametrize("decibels", [40, 30])
def test_frequencies_that_the_default_law_moves_beyond_their_errors_say_by_how_much(decibels: float) -> None:
    made = six_modes(decibels, 0, lower=1.0)
    model = six_mode_model(decibels, damping=Damping.STRUCTURAL)
    off = made.frequency - model.frequencies
    error = np.array([mode.standard_errors["frequency"] for mode in model.modes])
    said = np.array([law_flag(mode) or 0.0 for mode in model.modes])
    assert (np.abs(off) > 3 * error).sum() >= 4  # the law costs more than noise does
    assert ((said > 0) | (np.abs(off) < 2 * error)).all()
    # of six normal numbers one beyond 4 comes once in 2,600 such tests; two digits are said
    assert (np.abs(off - said) < 4 * error + 0.05 * said).all()


def test_who_asks_for_the_viscous_law_is_told_nothing_of_it() -> None:
    model = six_mode_model(30, damping=Damping.VISCOUS)
    assert [law_flag(mode) for mode in model.modes] == [None] * 6


def test_nothing_is_said_where_no_coherence_tells_the_random_error() -> None:
    model = six_mode_model(30, damping=Damping.STRUCTURAL, measured=False)
    assert [law_flag(mode) for mode in model.modes] == [None] * 6


@pytest.mark.parametrize("method", ["dobson", "lscf"])
def test_light_damping_in_noise_is_not_flagged(method: str, plain_beam: Beam, freq: np.ndarray) -> None:
    # the laws differ by 6 to 26 parts in a million, random error is 20 to 200
    frf, coherence = noise_of(plain_beam.frf(freq), 1, averages=5)
    model = extract(frf, coherence=coherence, averages=5, method=method)
    assert [law_flag(mode) for mode in model.modes] == [None] * 8

"""Lines with gaps, of two spacings and in proportion, for methods that need even ones."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.multi_mode.uniform_grid import places
from modallab.extraction.options import Damping, ExtractionOptions
from tests.synthetic import six_modes

CASE = six_modes(40, 0, lower=1.0)
AVERAGES = 1000.0
NEAR, DROPPED = np.abs(CASE.freq - 42.5) < 4, np.random.default_rng(3).random(len(CASE.freq)) < 0.5
EVERY_FOURTH = np.arange(len(CASE.freq)) % 4 == 0
IN_PROPORTION = np.isin(np.arange(len(CASE.freq)), np.searchsorted(CASE.freq, np.geomspace(1.1, 139.9, 700)))
KEPT = {
    "half of all dropped": ~DROPPED,
    "fine near the pair only": NEAR | EVERY_FOURTH,
    "a hole": np.abs(CASE.freq - 55) > 5,
    "in proportion": IN_PROPORTION,
}


def read(kept: np.ndarray) -> ModalModel:
    dofs = tuple(Dof(node, "Y") for node in range(1, 13))
    noisy = CASE.noisy[kept]
    frf = FrfSet(CASE.freq[kept], noisy[:, :, None], dofs, dofs[:1], FrfKind.RECEPTANCE)
    coherence = 1 / (1 + AVERAGES * CASE.variance[kept] / np.abs(noisy) ** 2)
    viscous = ExtractionOptions(damping=Damping.VISCOUS)
    return extract(frf, coherence=coherence, averages=AVERAGES, method="lscf", options=viscous)


@pytest.mark.parametrize("kept", KEPT.values(), ids=KEPT)
def test_modes_are_read_from_lines_in_any_spacing(kept: np.ndarray) -> None:
    model = read(kept)
    assert len(model.modes) == 6
    frequency = [mode.standard_errors["frequency"] for mode in model.modes]
    loss_factor = [mode.standard_errors["loss_factor"] for mode in model.modes]
    # of 48 normal numbers one beyond 4 comes once in 300 such lots; the error itself is 0.03 % at most
    assert (np.abs(model.frequencies - CASE.frequency) < 4 * np.array(frequency)).all()
    assert (np.abs(model.loss_factors - CASE.loss_factor) < 4 * np.array(loss_factor)).all()
    np.testing.assert_allclose(model.frequencies, CASE.frequency, rtol=1e-3)


def test_lines_with_gaps_keep_their_places() -> None:
    np.testing.assert_array_equal(places(np.array([10.0, 10.5, 12.0, 12.5])), [0, 1, 4, 5])
    np.testing.assert_array_equal(places(np.array([1.0, 2.0, 3.5])), [0, 2, 5])


def test_lines_written_with_few_digits_are_even() -> None:
    np.testing.assert_array_equal(places(np.round(np.arange(100) / 3, 2)), np.arange(100))


def test_lines_too_close_for_the_range_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="too close together"):
        places(np.array([1.0, 1.001, 500.0]))

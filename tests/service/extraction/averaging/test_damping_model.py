"""Structural or viscous: told by half a loss factor of phase."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.extraction.averaging.damping_model import select_damping_model
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping
from tests.service.extraction.conftest import Beam
from tests.service.extraction.six_mode_models import six_mode_model
from tests.service.extraction.test_extract import noise_of
from tests.synthetic import six_modes


@pytest.mark.parametrize("method", ["lscf", "dobson"])
@pytest.mark.parametrize("decibels", [40, 30])
def test_viscous_modes_are_read_by_the_viscous_law_unasked(decibels: float, method: str) -> None:
    model = six_mode_model(decibels, method=method, damping=None)
    assert model.choices["damping"].startswith(
        "viscous: determined from the lines, where modal constants have 1"
    )
    asked = six_mode_model(decibels, method=method, damping=Damping.VISCOUS)
    np.testing.assert_array_equal(model.frequencies, asked.frequencies)
    assert asked.choices["damping"] == "viscous: as requested"


def test_modes_of_the_law_that_was_told_are_where_they_are() -> None:
    made, model = six_modes(40, 0, lower=1.0), six_mode_model(40, damping=None)
    error = [mode.standard_errors["frequency"] for mode in model.modes]
    # of six normal numbers one beyond 3.5 comes once in 360 such tests; the other law moves four by more
    assert (np.abs(model.frequencies - made.frequency) < 3.5 * np.array(error)).all()
    assert not any(flag.startswith("damping_law") for mode in model.modes for flag in mode.flags)


@pytest.mark.parametrize("seed", range(3))
def test_structural_modes_stay_structural(seed: int, plain_beam: Beam, freq: np.ndarray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), seed, averages=100)
    model = extract(frf, coherence=coherence, averages=100, method="lscf")
    assert model.choices["damping"].startswith("structural: determined from the lines")


def test_the_law_that_is_asked_for_is_taken_whatever_the_lines_tell() -> None:
    model = six_mode_model(40, damping=Damping.STRUCTURAL)
    assert model.choices["damping"] == "structural: as requested"
    told = select_damping_model(model)
    assert told.damping is Damping.VISCOUS
    assert told.phase_ratio == pytest.approx(1.0, abs=4 * told.error)


def test_a_delay_is_not_taken_for_a_law() -> None:
    # it turns constants by 2 to 15 times what the law does, each mode by another
    told = select_damping_model(six_mode_model(40, damping=Damping.STRUCTURAL, delay=-1e-4))
    assert told.damping is None


def test_few_modes_tell_no_law() -> None:
    model = six_mode_model(40, damping=Damping.STRUCTURAL)
    alone = replace(
        model,
        modes=model.modes[:2],
        modal_constant=np.asarray(model.modal_constant)[:2],
        modal_constant_error=np.asarray(model.modal_constant_error)[:2],
        chart=None,
    )
    assert select_damping_model(alone).damping is None

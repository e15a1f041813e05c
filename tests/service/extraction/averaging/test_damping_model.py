"""Structural or viscous: told by half a loss factor of phase."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.damping_model import select_damping_model
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, ExtractionOptions
from tests.service.extraction.conftest import Beam
from tests.service.extraction.test_extract import noise_of
from tests.synthetic import six_modes

AVERAGES = 1000.0
STRUCTURAL = ExtractionOptions(damping=Damping.STRUCTURAL)


def viscous(decibels: float, method: str, options: ExtractionOptions, *, delay: float = 0.0) -> ModalModel:
    made = six_modes(decibels, 0, lower=1.0)
    noisy = made.noisy * np.exp(-2j * np.pi * made.freq[:, None] * delay)
    dofs = tuple(Dof(node, "Y") for node in range(1, 13))
    frf = FrfSet(made.freq, noisy[:, :, None], dofs, dofs[:1], FrfKind.RECEPTANCE)
    coherence = 1 / (1 + AVERAGES * made.variance / np.abs(made.noisy) ** 2)
    return extract(frf, coherence=coherence, averages=AVERAGES, method=method, options=options)


@pytest.mark.parametrize("method", ["lscf", "dobson"])
@pytest.mark.parametrize("decibels", [40, 30])
def test_viscous_modes_are_read_by_the_viscous_law_unasked(decibels: float, method: str) -> None:
    model = viscous(decibels, method, ExtractionOptions())
    assert model.choices["damping"].startswith(
        "viscous: determined from the lines, where modal constants have 1"
    )
    asked = viscous(decibels, method, ExtractionOptions(damping=Damping.VISCOUS))
    np.testing.assert_array_equal(model.frequencies, asked.frequencies)
    assert asked.choices["damping"] == "viscous: as requested"


def test_modes_of_the_law_that_was_told_are_where_they_are() -> None:
    made, model = six_modes(40, 0, lower=1.0), viscous(40, "lscf", ExtractionOptions())
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
    model = viscous(40, "lscf", STRUCTURAL)
    assert model.choices["damping"] == "structural: as requested"
    told = select_damping_model(model)
    assert told.damping is Damping.VISCOUS
    assert told.phase_ratio == pytest.approx(1.0, abs=4 * told.error)


def test_a_delay_is_not_taken_for_a_law() -> None:
    # it turns constants by 2 to 15 times what the law does, each mode by another
    told = select_damping_model(viscous(40, "lscf", STRUCTURAL, delay=-1e-4))
    assert told.damping is None


def test_few_modes_tell_no_law() -> None:
    model = viscous(40, "lscf", STRUCTURAL)
    alone = replace(
        model,
        modes=model.modes[:2],
        modal_constant=np.asarray(model.modal_constant)[:2],
        modal_constant_error=np.asarray(model.modal_constant_error)[:2],
        chart=None,
    )
    assert select_damping_model(alone).damping is None

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.reciprocity import modal_reciprocity, reciprocity
from modallab.fe.receptance import receptance
from tests.rigs import beam_system, dofs

FREQ = np.linspace(2.0, 500.0, 499)
SYSTEM = beam_system()
POINTS = dofs(1, 6, 14)
AVERAGES = 50.0


def square(outputs: tuple[Dof, ...] = POINTS, inputs: tuple[Dof, ...] = POINTS) -> FrfSet:
    """Return exact FRFs between points of a free beam, signs of DoFs in them."""
    values = receptance(SYSTEM, FREQ, SYSTEM.selection(outputs), SYSTEM.selection(inputs))
    return FrfSet(FREQ, values, outputs, inputs, FrfKind.RECEPTANCE)


def noisy(frf: FrfSet, seed: int, coherence: float) -> tuple[FrfSet, FloatArray]:
    rng = np.random.default_rng(seed)
    error = np.sqrt((1 - coherence) / (2 * AVERAGES * coherence))
    shape = frf.values.shape
    drawn = error * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return replace(frf, values=frf.values * (1 + drawn)), np.full(shape, coherence)


def test_exact_frfs_are_reciprocal_to_rounding_whatever_the_signs() -> None:
    turned = (POINTS[0], replace(POINTS[1], sign=-1), POINTS[2])
    for frf in (square(), square(turned, POINTS), square(POINTS, turned[::-1])):
        found = reciprocity(frf)
        assert found.pairs == ((POINTS[0], POINTS[1]), (POINTS[0], POINTS[2]), (POINTS[1], POINTS[2]))
        assert found.difference.max() < 1e-6  # rounding of two solutions at resonances
        np.testing.assert_allclose(found.scale, 1.0, atol=1e-6)
        assert np.isnan(found.misfit).all()
        assert not found.differs.any()


def test_random_error_is_no_difference() -> None:
    for seed in range(10):
        frf, coherence = noisy(square(), seed, 0.95)
        found = reciprocity(frf, coherence=coherence, averages=AVERAGES)
        # 499 lines know a mean square of a complex number to 4.5 %
        np.testing.assert_allclose(found.misfit, 1.0, atol=0.2)
        assert not found.differs.any()


def test_a_gain_and_a_polarity_show_in_their_pairs_as_a_scale() -> None:
    frf, coherence = noisy(square(), 3, 0.999)
    values = frf.values.copy()
    values[:, 1] *= -1.05  # the second response
    found = reciprocity(replace(frf, values=values), coherence=coherence, averages=AVERAGES)
    np.testing.assert_allclose(found.scale, [-1 / 1.05, 1.0, -1.05], rtol=0.01)
    assert found.differs.tolist() == [True, False, True]


def test_what_the_data_allow_is_said() -> None:
    assert "3 pairs" in reciprocity(square()).note
    hammer = reciprocity(square(POINTS[:2], dofs(1, 3, 6, 9, 14)))  # two accelerometers, five points struck
    assert len(hammer.pairs) == 1
    alone = reciprocity(square(POINTS, POINTS[:1]))
    assert (alone.pairs, len(alone.scale)) == ((), 0)
    assert alone.note.endswith("drive at a second of them")
    assert reciprocity(square(POINTS[:1], dofs(3, 9))).note.endswith("listen at a second of them")


def test_coherence_that_does_not_fit_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="does not fit"):
        reciprocity(square(), coherence=np.ones((499, 3)), averages=AVERAGES)
    with pytest.raises(InvalidInputError, match="averages"):
        reciprocity(square(), coherence=np.ones((499, 3, 3)))


def modes(drive: Dof, seed: int) -> ModalModel:
    frf, coherence = noisy(square(POINTS, (drive,)), seed, 0.98)
    return extract(frf, coherence=coherence, averages=AVERAGES)


def test_modal_constants_are_the_same_both_ways() -> None:
    first, second = modes(POINTS[0], 1), modes(POINTS[2], 2)
    found = modal_reciprocity(first, second)
    assert found.pairs == tuple((n, n) for n in range(6))  # 23 to 437 Hz
    off = np.abs(found.ratio - 1) / found.ratio_error
    assert 0.4 < np.sqrt((off**2).mean() / 2) < 1.6  # 12 numbers know their scatter to 20 %
    assert not found.differs.any()


def test_a_polarity_shows_in_every_mode() -> None:
    first, second = modes(POINTS[0], 1), modes(POINTS[2], 2)
    assert first.modal_constant is not None
    wrong = replace(first, modal_constant=-first.modal_constant)
    found = modal_reciprocity(wrong, second)
    np.testing.assert_allclose(found.ratio, -1.0, atol=0.2)
    assert found.differs.all()


def test_tests_that_do_not_hear_each_other_are_refused() -> None:
    first, second = modes(POINTS[0], 1), modes(POINTS[2], 2)
    deaf = replace(second, dofs=dofs(2, 3, 4))
    with pytest.raises(InvalidInputError, match="the second test"):
        modal_reciprocity(first, deaf)
    with pytest.raises(InvalidInputError, match="the first test"):
        modal_reciprocity(replace(first, modal_constant=None), second)

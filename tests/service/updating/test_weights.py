"""How measured numbers count: by their errors, mode by mode."""

from dataclasses import replace

import numpy as np

from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.settings import WEIGHTS
from modallab.updating.target import real_modes
from modallab.updating.weights import Weights
from tests.service.updating.cases import BEAM, BEAM_DOFS, modes_of

NOISE = ModeNoise(eigenvalue=0.005, eigenvector=0.05)


def test_stated_errors_are_the_units_and_no_scale_is_below_them() -> None:
    target = real_modes(modes_of(BEAM, 4, BEAM_DOFS, NOISE, 1))
    weights = Weights.of(target)
    assert target.errors is not None
    moving = target.errors > 1e-9  # a relative error of a node of a shape is none
    assert moving.sum() > 0.9 * target.n_rows
    np.testing.assert_array_equal(weights.units[moving], target.errors[moving])
    np.testing.assert_array_equal(weights.floors, np.ones(4))


def test_a_number_that_is_stated_as_exact_counts_as_exact_as_a_model_can_be() -> None:
    target = real_modes(modes_of(BEAM, 4, BEAM_DOFS, ModeNoise(eigenvalue=0.005), 1))
    weights = Weights.of(target)
    assert (weights.units > 0).all()
    size = np.sqrt((target.shapes**2).mean(axis=0))
    np.testing.assert_allclose(weights.units[4:8], WEIGHTS.min_relative_error * size)


def test_without_errors_shapes_count_less_whatever_their_scale() -> None:
    plain = modes_of(BEAM, 4, BEAM_DOFS)
    heavy = replace(plain, modes=tuple(replace(m, shape=m.shape / 100) for m in plain.modes))
    for target in (real_modes(plain), real_modes(heavy)):
        weights = Weights.of(target)
        np.testing.assert_array_equal(weights.units[:4], 1.0)
        relative = weights.units[4:].reshape(-1, 4) / np.sqrt((target.shapes**2).mean(axis=0))
        np.testing.assert_allclose(relative, WEIGHTS.shape_error_ratio)


def test_an_eigenvalue_is_in_one_block_with_its_shape() -> None:
    weights = Weights.of(real_modes(modes_of(BEAM, 3, BEAM_DOFS)))
    np.testing.assert_array_equal(weights.block[:3], [0, 1, 2])
    np.testing.assert_array_equal(weights.block[3:].reshape(-1, 3), [[0, 1, 2]] * len(BEAM_DOFS))


def test_modes_that_the_model_misses_are_named() -> None:
    weights = Weights.of(real_modes(modes_of(BEAM, 3, BEAM_DOFS, NOISE, 1)))
    assert weights.misfit_note(np.array([1.0, 4.0, 8.9])) == ""
    assert (
        weights.misfit_note(np.array([1.0, 25.0, 1.0]))
        == "; measured mode 2 missed by more than errors explain"
    )
    assert "modes 1, 3 missed" in weights.misfit_note(np.array([16.0, 1.0, 16.0]))

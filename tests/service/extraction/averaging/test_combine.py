from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import InconsistencyCause
from modallab.extraction.averaging.combine import combine_fits
from modallab.extraction.single_mode.fit_table import FitTable
from modallab.extraction.single_mode.screening import Screening

DOFS = tuple(Dof(node, "Y") for node in range(1, 5))


def table(constants: ComplexArray, *, outlying: tuple[int, ...] = ()) -> FitTable:
    """Two modes, the higher one first, in four FRFs."""
    shape = (2, 4)
    far = np.zeros(shape, bool)
    far[:, list(outlying)] = True
    return FitTable(
        frequency=np.array([[20.0, 20.1, 20.2, 25.0], [10.0, 10.0, 10.0, 10.4]]),
        loss_factor=np.full(shape, 0.01),
        modal_constant=constants,
        frequency_error=np.full(shape, 0.1),
        loss_factor_error=np.full(shape, 1e-4),
        modal_constant_error=np.full(shape, 0.01),
        screening=Screening(good=~far, unsure=np.zeros(shape, bool), outlying=far),
    )


PHI = np.array([[2.0 + 0.1j, -1.0, 0.5 - 0.2j, 0.3], [1.0, 1.0, -1.0j, 0.2]])


def test_shapes_come_back_from_their_modal_constants_in_rising_frequency() -> None:
    model = combine_fits(table(PHI[:, :1] * PHI), DOFS, DOFS[:1], method="dobson")
    assert model.frequencies[0] < model.frequencies[1]
    np.testing.assert_allclose(model.shapes, PHI[::-1].T, rtol=1e-12)  # rounding
    assert model.normalisation == "mass"


def test_an_outlier_is_named_and_left_out_of_mean_and_spread() -> None:
    model = combine_fits(table(PHI[:, :1] * PHI, outlying=(3,)), DOFS, DOFS[:1], method="dobson")
    mode = model.modes[1]
    assert mode.flags == ("outlier: 4:+Y",)
    assert mode.frequency == pytest.approx(20.1)
    spread = mode.frequency_spread
    assert spread is not None
    assert (spread.min, spread.max, spread.n) == (20.0, 20.2, 3)
    assert spread.sd == pytest.approx(0.1)  # 20.0, 20.1, 20.2 with n - 1
    assert mode.standard_errors["frequency"] == pytest.approx(0.1 / np.sqrt(3))
    assert model.fitted_frequency is not None
    assert model.fitted_frequency[1, 3] == 25.0  # shown all the same


def test_the_error_of_the_drive_point_reaches_every_component() -> None:
    constants = PHI[:, :1] * PHI
    model = combine_fits(table(constants), DOFS, DOFS[:1], method="dobson")
    stated = model.modes[1].shape_errors
    assert stated is not None
    rng = np.random.default_rng(1)
    noise = 0.01 * (rng.standard_normal((4000, 4)) + 1j * rng.standard_normal((4000, 4)))
    drawn = constants[0] + noise
    shapes = drawn / np.sqrt(drawn[:, :1])
    scatter = np.sqrt((np.abs(shapes - PHI[0]) ** 2).mean(axis=0) / 2)
    np.testing.assert_allclose(stated, scatter, rtol=0.05)  # 4000 draws: 1.1 %, and second order


@pytest.mark.parametrize("shared", [0.5, 1.0])
def test_what_all_constants_have_wrong_by_one_part_is_half_as_wrong_in_shapes(shared: float) -> None:
    constants = PHI[:, :1] * PHI
    part = 0.01  # of every constant
    given = replace(table(constants), modal_constant_error=part * np.abs(constants))
    stated = (
        combine_fits(given, DOFS, DOFS[:1], method="dobson", noise_correlation=shared).modes[1].shape_errors
    )
    assert stated is not None
    rng = np.random.default_rng(1)
    common, own = (
        rng.standard_normal((8000, n)) + 1j * rng.standard_normal((8000, n)) for n in (1, len(DOFS))
    )
    drawn = constants[0] * (1 + part * (np.sqrt(shared) * common + np.sqrt(1 - shared) * own))
    shapes = drawn / np.sqrt(drawn[:, :1])
    scatter = np.sqrt((np.abs(shapes - PHI[0]) ** 2).mean(axis=0) / 2)
    np.testing.assert_allclose(stated, scatter, rtol=0.04)  # 8000 draws: 0.8 %, and second order


def test_a_drive_point_out_of_phase_is_flagged() -> None:
    constants = PHI[:, :1] * PHI
    constants[:, 0] *= -1
    model = combine_fits(table(constants), DOFS, DOFS[:1], method="dobson")
    assert "drive point 1:+Y has a modal constant of the wrong sign" in model.modes[0].flags


def test_a_mode_that_no_frf_shows_well_is_left_out() -> None:
    shown = table(PHI[:, :1] * PHI)
    shown.screening.good[1] = False
    assert len(combine_fits(shown, DOFS, DOFS[:1], method="dobson").modes) == 1


def test_a_still_drive_point_leaves_no_shape_rather_than_nan() -> None:
    constants = PHI[:, :1] * PHI
    constants[1, 0] = 0
    model = combine_fits(table(constants), DOFS, DOFS[:1], method="dobson")
    assert np.isfinite(model.shapes).all()
    assert np.isfinite(combine_fits(table(0 * constants), DOFS, (Dof(9, "Y"),), method="dobson").shapes).all()


def one_structure(seed: int, errors: FloatArray, frequency: FloatArray | float = 100.0) -> FitTable:
    """Return one mode in many FRFs, each with its own random error of frequency and damping, Hz."""
    rng = np.random.default_rng(seed)
    n = len(errors)
    of_damping = 2e-4 * errors
    everywhere = np.ones((1, n), bool)
    return FitTable(
        frequency=(frequency + errors * rng.standard_normal(n))[None],
        loss_factor=(0.01 + of_damping * rng.standard_normal(n))[None],
        modal_constant=np.ones((1, n), complex),
        frequency_error=errors[None],
        loss_factor_error=of_damping[None],
        modal_constant_error=np.full((1, n), 0.01),
        screening=Screening(good=everywhere, unsure=~everywhere, outlying=~everywhere),
    )


def test_frfs_of_one_structure_count_as_they_are_sure_and_the_error_is_honest() -> None:
    errors = np.geomspace(0.02, 0.6, 11)
    dofs = tuple(Dof(node, "Y") for node in range(1, 12))
    scores, damping, plain = [], [], []
    for seed in range(600):
        model = combine_fits(one_structure(seed, errors), dofs, dofs[:1], method="dobson")
        mode = model.modes[0]
        scores.append((mode.frequency - 100.0) / mode.standard_errors["frequency"])
        damping.append((mode.loss_factor - 0.01) / mode.standard_errors["loss_factor"])
        assert mode.frequency_spread is not None
        plain.append(mode.frequency_spread.mean - 100.0)
    for score in (scores, damping):
        # 600 draws know a share of 95 % to 0.9 %
        assert 0.93 < (np.abs(score) < 1.96).mean() < 0.97
        assert abs(np.mean(score)) < 0.15  # 3.7 times what 600 draws leave: weights follow no result
    assert np.std(plain) > 4 * mode.standard_errors["frequency"]
    assert model.choices["means"].startswith("weighted")
    assert model.frequency_inconsistency is None


def test_frfs_that_differ_without_a_pattern_have_their_scatter_in_the_error() -> None:
    dofs = tuple(Dof(node, "Y") for node in range(1, 12))
    moved = 100.0 + 0.2 * np.random.default_rng(1).standard_normal(11)
    model = combine_fits(one_structure(2, np.full(11, 0.01), moved), dofs, dofs[:1], method="dobson")
    assert model.frequency_inconsistency is not None
    assert model.frequency_inconsistency.cause is InconsistencyCause.UNKNOWN
    (mode,) = model.modes
    spread = mode.frequency_spread
    assert spread is not None
    assert mode.frequency == pytest.approx(spread.mean, rel=1e-12)  # rounding
    assert mode.standard_errors["frequency"] == pytest.approx(spread.sd / np.sqrt(11))
    assert mode.standard_errors["loss_factor"] == pytest.approx(2e-6 / np.sqrt(11), rel=0.01)  # that agrees
    assert any("neither the squared shape" in note for note in model.notes)


def test_an_outlier_says_how_far_off_it_is() -> None:
    model = combine_fits(table(PHI[:, :1] * PHI, outlying=(3,)), DOFS, DOFS[:1], method="dobson")
    assert any(note.startswith("mode 2, 4:+Y left out: +4.9 Hz") for note in model.notes)


def test_constants_come_with_errors_and_the_point_that_all_frfs_share() -> None:
    model = combine_fits(table(PHI[:, :1] * PHI), DOFS, DOFS[:1], method="dobson", choices={"lines": "8"})
    assert model.modal_constant_error is not None
    np.testing.assert_array_equal(model.modal_constant_error, np.full((2, 4), 0.01))
    assert model.drive == DOFS[0]
    assert model.choices["lines"] == "8"


def test_a_shape_whose_phases_differ_is_flagged() -> None:
    model = combine_fits(table(PHI[:, :1] * PHI), DOFS, DOFS[:1], method="dobson")
    # by hand: phi^T phi = 1 + 1 - 1 + 0.04, phi^H phi = 3.04; the square of 1.04/3.04
    assert model.modes[0].flags == ("complex shape: phase collinearity 0.12",)
    assert model.modes[1].flags == ()

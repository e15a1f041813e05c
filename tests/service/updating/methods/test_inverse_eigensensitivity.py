"""Two-stage inverse eigensensitivity: it finds what was hidden, and says what it cannot."""

from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

from modallab.core.errors import UnderdeterminedError
from modallab.core.modal_model import ModalModel
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.synthetic_modes import Distribution, ModeNoise
from modallab.updating.method import UpdateResult
from modallab.updating.methods.inverse_eigensensitivity import inverse_eigensensitivity
from modallab.updating.options import TwoStageOptions
from modallab.updating.parameterisation import parameterise
from modallab.updating.partitioning import automatic_groups
from tests.service.updating.cases import BAY, BAY_DOFS, BEAM, BEAM_DOFS, WRONG_BEAM, modes_of

FIVE = parameterise([tuple(range(i, i + 4)) for i in range(1, 21, 4)])


def moved(result: UpdateResult, part: str, tolerance: float) -> dict[int, float]:
    return {n: v for n, v in result.coefficients[part].items() if abs(v - 1) > tolerance}


def test_parts_that_were_not_suspected_stay_as_they_were() -> None:
    lighter = change(BEAM, [MemberChange((5, 6, 7, 8), MemberProperty.DENSITY, factor=1.2)])
    result = inverse_eigensensitivity(BEAM, FIVE, modes_of(lighter, 8, BEAM_DOFS))
    assert result.suspected == {"mass": (5, 6, 7, 8), "stiffness": ()}
    assert moved(result, "stiffness", 0.0) == {}
    # exactly what was hidden: the tolerance of the last step is 1e-4, and it converges quadratically
    assert moved(result, "mass", 1e-6) == pytest.approx(dict.fromkeys((5, 6, 7, 8), 1.2), abs=1e-6)


def test_area_and_second_moment_are_found_apart() -> None:
    wrong = change(
        BAY,
        [
            MemberChange((5, 6, 7), MemberProperty.AXIAL_STIFFNESS, factor=1.3),
            MemberChange((8, 9, 10), MemberProperty.BENDING_STIFFNESS, factor=0.8),
        ],
    )
    parameters = parameterise(automatic_groups(BAY), ("axial", "bending"))
    result = inverse_eigensensitivity(BAY, parameters, modes_of(wrong, 10, BAY_DOFS))
    assert result.converged, result.stopped_because
    assert moved(result, "axial", 1e-3) == pytest.approx(dict.fromkeys((5, 6, 7), 1.3), abs=1e-3)
    assert moved(result, "bending", 1e-3) == pytest.approx(dict.fromkeys((8, 9, 10), 0.8), abs=1e-3)


def test_shapes_without_a_scale_find_stiffness_too() -> None:
    stiffer = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0)])
    target = modes_of(stiffer, 8, BEAM_DOFS)
    scaled = tuple(
        replace(mode, shape=mode.shape * (-3.0 if r % 2 else 0.2)) for r, mode in enumerate(target.modes)
    )
    target = replace(target, modes=scaled, normalisation="none")
    parameters = parameterise([m.members for m in FIVE.macros[:5]], ("stiffness",))
    result = inverse_eigensensitivity(BEAM, parameters, target)
    assert result.converged, result.stopped_because
    assert moved(result, "stiffness", 1e-3) == pytest.approx({11: 2.0, 12: 2.0}, abs=1e-3)


def test_standard_errors_are_the_scatter_of_repeated_tests() -> None:
    stiffer = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=1.5)])
    parameters = parameterise([(9, 10), (11, 12), (13, 14)], ("stiffness",))
    noise = ModeNoise(eigenvalue=1e-3, eigenvector=1e-2, distribution=Distribution.NORMAL)
    options = TwoStageOptions(suspect_threshold=0.0)
    found = [
        inverse_eigensensitivity(
            BEAM, parameters, modes_of(stiffer, 8, BEAM_DOFS, noise, seed), options=options
        )
        for seed in range(40)
    ]
    values = np.array([[r.coefficients["stiffness"][n] for n in (9, 11, 13)] for r in found])
    stated = np.array([[r.standard_errors["stiffness"][n] for n in (9, 11, 13)] for r in found])
    ratio = values.std(axis=0, ddof=1) / np.sqrt((stated**2).mean(axis=0))
    # the scatter of 40 draws is itself known to 1/sqrt(2 * 39) = 11 %: three of these
    np.testing.assert_allclose(ratio, 1.0, atol=0.34)


def test_errors_come_from_the_residual_where_none_are_stated() -> None:
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS, ModeNoise(eigenvector=0.01), seed=5)
    silent = replace(
        target, modes=tuple(replace(m, standard_errors={}, shape_errors=None) for m in target.modes)
    )
    stated = inverse_eigensensitivity(BEAM, FIVE, target).standard_errors["stiffness"]
    guessed = inverse_eigensensitivity(BEAM, FIVE, silent).standard_errors["stiffness"]
    assert stated.keys() == guessed.keys()
    # one variance for all rows instead of one each: the same order of size
    ratios = np.array([guessed[n] / stated[n] for n in stated])
    assert ((ratios > 0.2) & (ratios < 5.0)).all()


def test_every_step_is_on_record() -> None:
    result = inverse_eigensensitivity(BEAM, FIVE, modes_of(WRONG_BEAM, 8, BEAM_DOFS))
    assert result.iterations == {"location": 4, "updating": 6}
    assert [one.stage for one in result.history] == ["location"] * 4 + ["updating"] * 6
    assert all(one.rank == len(one.macros) == len(one.coefficients) for one in result.history)
    updating = [one for one in result.history if one.stage == "updating"]
    assert max(one.max_change for one in updating) <= 0.3 * (1 + 1e-12)
    np.testing.assert_array_equal(updating[-1].frequencies, result.frequencies.after)
    assert all(one.condition_number < 100 for one in updating)  # 1e8 and more without balance


def retuned(target: ModalModel, *factors: float) -> ModalModel:
    """Multiply frequencies in turn: no beam of these shapes has such frequencies."""
    modes = zip(target.modes, cycle(factors), strict=False)
    return replace(target, modes=tuple(replace(m, frequency=m.frequency * f) for m, f in modes))


def test_an_impossible_target_ends_with_a_reason_and_finite_numbers() -> None:
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS)
    bent = tuple(
        replace(m, frequency=m.frequency * (1.6 if r % 2 else 0.7)) for r, m in enumerate(target.modes)
    )
    result = inverse_eigensensitivity(BEAM, FIVE, replace(target, modes=bent))
    assert not result.converged
    assert result.stopped_because
    for one in result.history:
        assert np.isfinite(one.coefficients).all()
        assert (one.coefficients >= FIVE.lower * (1 - 1e-9)).all()
        assert (one.coefficients <= FIVE.upper * (1 + 1e-9)).all()
    assert np.isfinite(list(result.coefficients["mass"].values())).all()


def test_a_path_that_loses_a_mode_ends_where_it_still_made_sense() -> None:
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS)
    wide = parameterise([m.members for m in FIVE.macros[:5]], lower=1e-3, upper=1e3)
    result = inverse_eigensensitivity(BEAM, wide, retuned(target, 0.3, 3.0))
    assert not result.converged
    assert result.stopped_because.startswith("diverged")
    assert result.iterations["updating"] == 0
    assert result.standard_errors == {}
    np.testing.assert_array_equal(result.frequencies.after, result.frequencies.location)


def test_bounds_are_kept_and_do_not_hold_up_the_rest() -> None:
    parameters = parameterise([m.members for m in FIVE.macros[:5]], lower=0.8, upper=1.25)
    result = inverse_eigensensitivity(BEAM, parameters, modes_of(WRONG_BEAM, 8, BEAM_DOFS))
    assert result.iterations["location"] < 30  # it comes to rest where the bounds allow
    values = np.array([v for table in result.coefficients.values() for v in table.values()])
    assert values.min() >= 0.8 * (1 - 1e-9)
    assert values.max() <= 1.25 * (1 + 1e-9)
    assert values.max() == pytest.approx(1.25)  # the truth, 2, is beyond
    assert "rest on a bound" in result.stopped_because


def test_more_coefficients_than_measured_numbers_are_refused() -> None:
    each, target = parameterise([(n,) for n in range(1, 21)]), modes_of(WRONG_BEAM, 3, BEAM_DOFS[:4])
    with pytest.raises(UnderdeterminedError) as caught:
        inverse_eigensensitivity(BEAM, each, target)
    assert caught.value.context == {"field": "macros", "value": 40, "allowed": {"maximum": 15}}


def test_frequencies_alone_do_where_they_are_more_than_the_coefficients() -> None:
    stiffer = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=1.5)])
    parameters = parameterise([(3, 4), (11, 12)], ("stiffness",))
    # errors of half of every entry: enough is left for modes to pair
    exact = modes_of(stiffer, 8, BEAM_DOFS)
    spoilt = modes_of(stiffer, 8, BEAM_DOFS, ModeNoise(eigenvector=0.5), 1)
    without, with_shapes = (
        inverse_eigensensitivity(BEAM, parameters, spoilt, options=TwoStageOptions(n_shapes=n))
        for n in (0, 8)
    )
    # clamped nowhere, the beam is alike from both ends, and so are its frequencies: 9 and 10 are like 11, 12
    assert without.converged, without.stopped_because
    assert moved(without, "stiffness", 1e-6) == pytest.approx({11: 1.5, 12: 1.5}, abs=1e-6)
    assert abs(with_shapes.coefficients["stiffness"][11] - 1.5) > 0.01
    np.testing.assert_allclose(without.frequencies.after, exact.frequencies, rtol=1e-6)


def test_fewer_shapes_leave_fewer_numbers() -> None:
    target = modes_of(BEAM, 8, BEAM_DOFS)
    # eight eigenvalues and one shape at eleven places
    with pytest.raises(UnderdeterminedError, match="19 measured numbers cannot determine 40"):
        inverse_eigensensitivity(
            BEAM, parameterise([(n,) for n in range(1, 21)]), target, options=TwoStageOptions(n_shapes=1)
        )


def test_errors_of_shapes_that_are_left_out_do_not_count() -> None:
    stiffer = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=1.5)])
    parameters, options = parameterise([(11, 12)], ("stiffness",)), TwoStageOptions(n_shapes=0)
    noise = ModeNoise(eigenvalue=1e-3, eigenvector=1e-2)
    exact_shapes = ModeNoise(eigenvalue=1e-3, eigenvector=1e-3)
    one, other = (
        inverse_eigensensitivity(
            BEAM, parameters, modes_of(stiffer, 8, BEAM_DOFS, level, 3), options=options
        ).standard_errors["stiffness"][11]
        for level in (noise, exact_shapes)
    )
    assert one == pytest.approx(other, rel=1e-9)

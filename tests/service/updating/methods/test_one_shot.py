"""All coefficients at once: what is wrong is found without asking where, and what is not known is told."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from benchmarks.one_shot import CLOSE, ITERATIONS, NL3, SEEDS, WRONG, exact, garteur, measured, noisy
from modallab.core.errors import InvalidInputError, UnderdeterminedError
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.method import UpdateResult
from modallab.updating.methods.one_shot import one_shot
from modallab.updating.options import OneStageOptions, Underdetermined
from modallab.updating.parameterisation import parameterise
from modallab.updating.sparse_bayes import Prior
from tests.service.updating.cases import BAY, BEAM, BEAM_DOFS, WRONG_BEAM, modes_of

EACH = parameterise([(member.number,) for member in BAY.members])
BEAM_EACH = parameterise([(member.number,) for member in BEAM.members])


@cache
def from_noise(seed: int) -> UpdateResult:
    return one_shot(BAY, EACH, measured(WRONG, NL3, seed))


@pytest.mark.parametrize("seed", [0, 8, 15, 37])  # one to eleven wrong coefficients, close modes that swap
def test_all_coefficients_of_the_bay_are_found_at_once(seed: int) -> None:
    error, iterations = exact(seed)
    assert error < CLOSE
    assert iterations <= ITERATIONS


def test_half_as_many_coefficients_as_measured_numbers_are_found_from_five_modes() -> None:
    assert garteur(2) < 1e-6  # ten of 83 members wrong, 166 coefficients, 365 exact numbers


def test_right_coefficients_stay_exactly_where_they_were() -> None:
    result = one_shot(BEAM, BEAM_EACH, modes_of(WRONG_BEAM, 8, BEAM_DOFS))
    assert result.converged, result.stopped_because
    assert result.suspected == {"mass": (1, 2), "stiffness": (11, 12)}
    for part, wrong in (("mass", (1, 2)), ("stiffness", (11, 12))):
        for number, value in result.coefficients[part].items():
            assert value == (pytest.approx(2.0, abs=1e-6) if number in wrong else 1.0)


def test_noise_hides_no_wrong_element_and_moves_frequencies_little() -> None:
    for seed in range(4):
        result = from_noise(seed)
        assert set(result.suspected["mass"]) == {25, 26}
        assert set(result.suspected["stiffness"]) == {12, 13, 31}
        assert result.frequencies.measured is not None
        # eigenvalues of 0.5 % are frequencies of 0.25 % off, evenly drawn: the update lies inside
        np.testing.assert_allclose(result.frequencies.after, result.frequencies.measured, rtol=0.004)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    # of 62 coefficients that share their errors, ten draws: 95 % to within a few
    covered = np.mean([noisy(seed).covered for seed in range(SEEDS - 10, SEEDS)])
    assert 0.90 <= covered <= 0.99


def test_what_data_cannot_tell_apart_is_named() -> None:
    told = from_noise(0).identifiability
    assert told is not None
    assert told.rank == 62
    words = [one.words for one in told.directions]
    assert "mass and stiffness of 10-12 can hardly be told apart by these data" in words
    assert all(one.standard_error is not None and one.standard_error > 0.3 for one in told.directions)


def test_many_small_errors_are_found_by_a_prior_common_to_all() -> None:
    rng = np.random.default_rng(3)
    wrong = {
        (part, n): float(np.exp(0.1 * rng.standard_normal()))
        for part in ("mass", "stiffness")
        for n in range(1, 32)
    }
    target = measured(wrong, ModeNoise(eigenvalue=0.001, eigenvector=0.01), 4)

    def rms(prior: str) -> float:
        found = one_shot(BAY, EACH, target, options=OneStageOptions(prior=Prior(prior))).coefficients
        return float(np.sqrt(np.mean([(found[part][n] - wrong[part, n]) ** 2 for part, n in wrong])))

    assert rms("common") < 0.07  # of errors of 0.1; the data leave single directions open
    assert rms("common") < rms("range")


@pytest.mark.parametrize("noise", [None, NL3], ids=["exact", "NL3"])
def test_a_modulus_wrong_everywhere_leaves_shapes_alone_and_is_found_by_frequencies(
    noise: ModeNoise | None,
) -> None:
    wrong = {("stiffness", member.number): 1.3 for member in BAY.members}
    result = one_shot(BAY, EACH, measured(wrong, noise or ModeNoise(), 1))
    assert result.frequencies.measured is not None
    # eigenvalues of 0.5 % are frequencies of 0.25 % off
    rtol = 0.0025 if noise else 1e-6
    np.testing.assert_allclose(result.frequencies.after, result.frequencies.measured, rtol=rtol)
    # 31 coefficients that all differ are less sure than a few
    np.testing.assert_allclose(
        list(result.coefficients["stiffness"].values()), 1.3, atol=0.1 if noise else 1e-6
    )


def test_a_mode_that_was_read_wrong_is_named_and_leaves_the_others_alone() -> None:
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS)
    third = replace(target.modes[2], frequency=2 * target.modes[2].frequency)
    modes = (*target.modes[:2], third, *target.modes[3:])
    result = one_shot(BEAM, BEAM_EACH, replace(target, modes=modes))
    assert "; measured mode 3 missed by more than errors explain" in result.stopped_because
    assert result.suspected == {"mass": (1, 2), "stiffness": (11, 12)}
    others = np.arange(8) != 2
    # exact modes: what is left is the tolerance of the last step, 1e-4, squared
    np.testing.assert_allclose(result.frequencies.after[others], target.frequencies[others], rtol=1e-6)


def test_fewer_numbers_than_coefficients_are_refused_with_their_count_or_regularised() -> None:
    target = modes_of(WRONG_BEAM, 3, BEAM_DOFS)
    with pytest.raises(UnderdeterminedError, match="36 measured numbers cannot determine 40 coefficients"):
        one_shot(BEAM, BEAM_EACH, target)
    result = one_shot(
        BEAM, BEAM_EACH, target, options=OneStageOptions(underdetermined=Underdetermined.REGULARISED)
    )
    assert result.converged, result.stopped_because
    assert result.frequencies.measured is not None
    np.testing.assert_allclose(result.frequencies.after, result.frequencies.measured, rtol=1e-4)
    told = result.identifiability
    assert told is not None
    assert told.rank <= 36
    assert sum(one.standard_error is None for one in told.directions) == 40 - told.rank
    # equations that are all met tell nothing of their errors
    assert result.standard_errors == {}
    assert told.covariance is None
    np.testing.assert_array_equal(told.intervals, [[0.05, 10.0]] * 40)


def test_coefficients_that_no_measured_number_shows_are_refused() -> None:
    # bending of a beam strains nothing lengthwise
    axial = parameterise([(member.number,) for member in BEAM.members], ("axial",))
    with pytest.raises(UnderdeterminedError, match="no measured number moves with any coefficient"):
        one_shot(BEAM, axial, modes_of(WRONG_BEAM, 8, BEAM_DOFS))


def test_a_coefficient_that_nothing_shows_is_named_and_stays() -> None:
    parts = parameterise([(11, 12), (13, 14)], ("bending", "axial"))
    stiffer = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=1.4)])
    result = one_shot(BEAM, parts, modes_of(stiffer, 8, BEAM_DOFS))
    assert result.coefficients["axial"][11] == 1.0
    assert result.coefficients["bending"][11] == pytest.approx(1.4, abs=1e-6)
    assert result.intervals["axial"][11] == (0.05, 10.0)
    told = result.identifiability
    assert told is not None
    assert {str(macro) for macro in told.unidentified} == {"axial of 11, 12", "axial of 13, 14"}
    assert "axial of 13, 14 does not show in these data" in [one.words for one in told.directions]


def test_bounds_are_kept_and_the_others_found_given_them() -> None:
    narrow = parameterise([(member.number,) for member in BEAM.members], lower=0.8, upper=1.25)
    result = one_shot(BEAM, narrow, modes_of(WRONG_BEAM, 8, BEAM_DOFS))
    values = np.array([v for table in result.coefficients.values() for v in table.values()])
    assert values.min() >= 0.8 * (1 - 1e-9)
    assert values.max() == pytest.approx(1.25)  # the truth, 2, is beyond
    assert "rest on a bound" in result.stopped_because


def test_an_impossible_target_ends_with_a_reason_and_finite_numbers() -> None:
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS)
    bent = tuple(
        replace(m, frequency=m.frequency * (1.6 if r % 2 else 0.7)) for r, m in enumerate(target.modes)
    )
    result = one_shot(BEAM, BEAM_EACH, replace(target, modes=bent))
    assert result.stopped_because
    assert result.history
    for one in result.history:
        assert np.isfinite(one.coefficients).all()
        assert (one.coefficients >= EACH.lower).all()
        assert (one.coefficients <= EACH.upper).all()
    assert np.isfinite(list(result.coefficients["mass"].values())).all()


def test_an_unknown_prior_is_refused_by_name() -> None:
    unknown: dict[str, Any] = {"prior": "flat"}
    with pytest.raises(InvalidInputError, match="no prior 'flat'") as refused:
        OneStageOptions(**unknown)
    assert refused.value.context["allowed"] == ["sparse", "common", "range"]

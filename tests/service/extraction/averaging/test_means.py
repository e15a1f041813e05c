import numpy as np
import pytest

from modallab.extraction.averaging.means import (
    Averaging,
    averaged,
    differ_significantly,
    plain_mean,
    weighted_mean,
)


def test_weights_are_one_over_variance() -> None:
    mean = weighted_mean(np.array([10.0, 10.1]), np.array([0.1, 0.2]), 0.0)
    assert mean.value == pytest.approx((10.0 / 0.01 + 10.1 / 0.04) / (1 / 0.01 + 1 / 0.04), rel=1e-12)
    assert mean.error == pytest.approx(1 / np.sqrt(1 / 0.01 + 1 / 0.04), rel=1e-12)  # rounding


def test_of_equal_errors_both_means_are_one() -> None:
    values, errors = np.array([1.0, 2.0, 3.0]), np.full(3, 1.5)
    weighted, plain = weighted_mean(values, errors, 0.0), plain_mean(values, errors)
    assert weighted.value == pytest.approx(plain.value, rel=1e-12)  # rounding
    assert weighted.error == pytest.approx(plain.error, rel=1e-12)


def test_the_weighted_mean_scatters_as_it_says_and_less_than_the_plain_one() -> None:
    rng = np.random.default_rng(1)
    errors = np.geomspace(0.1, 3.0, 11)
    drawn = 50.0 + errors * rng.standard_normal((2000, 11))
    weighted = [weighted_mean(row, errors, 0.0) for row in drawn]
    plain = [plain_mean(row, errors) for row in drawn]
    scatter = np.std([mean.value for mean in weighted])
    assert scatter == pytest.approx(weighted[0].error, rel=0.08)  # 2000 draws: 1.6 %; bounded pull: 2 %
    assert scatter < 0.3 * np.std([mean.value for mean in plain])
    assert np.mean([mean.value for mean in weighted]) == pytest.approx(50.0, abs=4 * scatter / np.sqrt(2000))


def test_one_value_however_far_pulls_no_further() -> None:
    values, errors = np.full(11, 20.0), np.full(11, 0.01)
    values[3] = 21.0
    near = weighted_mean(values, errors, 0.0).value
    values[3] = 1000.0
    far = weighted_mean(values, errors, 0.0).value
    assert near == pytest.approx(far, abs=1e-6)
    assert abs(far - 20.0) < 0.01 / 3  # 2.5 standard errors shared among eleven


def test_values_known_better_than_they_can_be_count_alike() -> None:
    values = np.array([1.0, 1.2, 1.1])
    assert weighted_mean(values, np.array([1e-9, 1e-6, 1e-9]), 0.1).value == pytest.approx(1.1, rel=1e-6)
    assert weighted_mean(values, np.zeros(3), 0.0).value == pytest.approx(1.0, abs=0.2)


def test_values_that_differ_have_their_scatter_in_the_error() -> None:
    values, errors = np.array([1.0, 1.2, 1.1, 0.9]), np.full(4, 1e-3)
    assert differ_significantly(values, errors)
    mean = averaged(values, errors, 0.0, Averaging.WEIGHTED)
    assert mean.value == pytest.approx(1.05)
    assert mean.error == pytest.approx(values.std(ddof=1) / 2)
    assert averaged(values, errors, 0.0, Averaging.PLAIN).error == pytest.approx(5e-4)


def test_one_value_apart_is_no_scatter() -> None:
    assert not differ_significantly(np.array([1.0, 1.0, 1.0, 2.0]), np.full(4, 1e-3))
    assert not differ_significantly(np.array([1.0]), np.array([0.1]))
    assert not differ_significantly(np.array([1.0, 2.0, 3.0]), np.zeros(3))


def test_errors_in_common_do_not_average_out() -> None:
    values, errors = np.full(9, 5.0), np.full(9, 0.3)
    assert plain_mean(values, errors).error == pytest.approx(0.1)
    assert plain_mean(values, errors, 1.0).error == pytest.approx(0.3)
    for mean in (plain_mean(values, errors, 0.5), weighted_mean(values, errors, 0.0, 0.5)):
        assert mean.error == pytest.approx(np.sqrt(0.5 * 0.01 + 0.5 * 0.09))

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.extraction.multi_mode.fit_settings import PROJECTION
from modallab.extraction.multi_mode.line_groups import proportional_groups, similar_groups

N_LINES, N_FRF = 40, 5


def weights_in_groups(rng: np.random.Generator) -> FloatArray:
    level = rng.uniform(0.5, 2.0, (4, N_FRF)).repeat(10, axis=0)
    return np.asarray(level * rng.uniform(0.1, 10.0, (N_LINES, 1)))


def test_lines_with_proportional_weights_are_one_group() -> None:
    weight = weights_in_groups(np.random.default_rng(1))
    groups = proportional_groups(weight)
    np.testing.assert_array_equal(groups.group, np.arange(4).repeat(10))
    np.testing.assert_allclose(groups.weight, weight, rtol=1e-14)  # rounding of a quotient and a product
    assert groups.worthwhile


def test_weights_by_line_and_frf_have_no_groups_that_save_time() -> None:
    weight = np.random.default_rng(2).uniform(0.5, 2.0, (N_LINES, N_FRF))
    groups = proportional_groups(weight)
    assert len(groups.level) == N_LINES
    assert not groups.worthwhile
    np.testing.assert_allclose(groups.weight, weight, rtol=1e-14)  # rounding of a quotient and a product


def test_similar_weights_are_the_reciprocal_of_the_mean_variance_of_a_group() -> None:
    rng = np.random.default_rng(3)
    weight = rng.uniform(0.5, 2.0, (N_LINES, N_FRF))
    groups = similar_groups(weight)
    lines = slice(0, PROJECTION.similar_lines)
    factor = groups.profile[lines, None]
    # rounding of a mean
    np.testing.assert_allclose(1 / groups.level[0], (factor / weight[lines]).mean(axis=0), rtol=1e-12)
    assert groups.worthwhile


def test_lines_that_an_frf_leaves_out_stay_without_weight_in_it() -> None:
    weight = weights_in_groups(np.random.default_rng(4))
    weight[12:15, 2] = 0.0
    weight[20] = 0.0
    for groups in (proportional_groups(weight), similar_groups(weight)):
        np.testing.assert_array_equal(groups.weight == 0, weight == 0)

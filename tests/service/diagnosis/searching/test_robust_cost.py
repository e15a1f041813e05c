"""What a first look leaves: squares that saturate."""

import numpy as np
import pytest

from modallab.diagnosis.searching.robust_cost import cauchy_loss
from modallab.diagnosis.searching.scan_settings import LOSS


@pytest.mark.parametrize("n", [1, 3, 4, 7, 1000])
def test_squares_of_any_number_and_size_saturate_one_by_one(n: int) -> None:
    squares = 10.0 ** np.random.default_rng(n).uniform(-12, 60, (3, n))
    each = LOSS.cauchy_scale * np.log1p(squares / LOSS.cauchy_scale)
    # 1 + s is rounded before its logarithm, by 1e-16 a number
    np.testing.assert_allclose(cauchy_loss(squares), each.sum(axis=-1), rtol=1e-12, atol=1e-14 * n)

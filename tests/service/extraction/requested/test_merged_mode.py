"""One mode in place of several of which the same mode was estimated."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.modal_model import Mode, Spread
from modallab.extraction.requested.merged_mode import merged_mode

SHAPE = np.array([1.0, -0.5, 0.2], complex)


def mode(frequency: float, error: float, shape_error: float = 0.01, sense: float = 1.0) -> Mode:
    return Mode(
        frequency,
        0.01,
        np.asarray(sense * SHAPE, complex),
        standard_errors={"frequency": error, "loss_factor": 1e-4},
        shape_errors=np.full(3, shape_error),
        flags=("node: 5:+Y",),
    )


def test_precise_estimates_weigh_more() -> None:
    merged = merged_mode([mode(100.0, 0.1), mode(100.2, 0.2)])
    assert merged.frequency == pytest.approx((4 * 100.0 + 100.2) / 5)
    assert merged.standard_errors["frequency"] == pytest.approx(1 / np.sqrt(1 / 0.1**2 + 1 / 0.2**2))
    assert merged.standard_errors["loss_factor"] == pytest.approx(1e-4 / np.sqrt(2))
    assert merged.flags == ("merged: from 100 and 100.2 Hz", "node: 5:+Y")


def test_errors_are_those_of_the_scatter_where_it_is_larger() -> None:
    merged = merged_mode([mode(100.0, 0.01), mode(101.0, 0.01)])
    assert merged.standard_errors["frequency"] == pytest.approx(0.5)  # half the difference, of two


def test_shapes_are_averaged_in_one_sense() -> None:
    merged = merged_mode([mode(100.0, 0.1), mode(100.0, 0.1, sense=-1.0)])
    np.testing.assert_allclose(merged.shape, SHAPE, atol=1e-12)
    assert merged.shape_errors is not None
    np.testing.assert_allclose(merged.shape_errors, 0.01 / np.sqrt(2))


def test_a_mode_without_errors_leaves_a_plain_mean() -> None:
    bare = replace(mode(100.0, 0.1), standard_errors={}, shape_errors=None)
    merged = merged_mode([bare, mode(101.0, 0.1)])
    assert merged.frequency == pytest.approx(100.5)
    assert (merged.standard_errors, merged.shape_errors) == ({}, None)


def test_spreads_are_those_of_all_values_together() -> None:
    values = np.array([1.0, 2.0, 4.0]), np.array([5.0, 9.0])
    spreads = [Spread(v.min(), v.max(), v.mean(), v.std(ddof=1), len(v)) for v in values]
    merged = merged_mode([replace(mode(1.0, 0.1), frequency_spread=spread) for spread in spreads])
    together = np.concatenate(values)
    assert merged.frequency_spread is not None
    assert merged.frequency_spread.mean == pytest.approx(together.mean())
    assert merged.frequency_spread.sd == pytest.approx(together.std(ddof=1))
    assert (merged.frequency_spread.min, merged.frequency_spread.max, merged.frequency_spread.n) == (1, 9, 5)

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.residuals.line_correlation import LineCorrelation
from modallab.diagnosis.residuals.residual import Residual
from modallab.diagnosis.residuals.settings import LINE_CORRELATION

N_LINES, N_OUT = 1500, 3
EVERY = np.ones((N_LINES, N_OUT), bool)
TAPER = 1 - 1 / (LINE_CORRELATION.pooled_lags + 1)  # of the nearest neighbours


def mixed(seed: int, *, mix: bool) -> Residual:
    """Return residuals of unit variance; mixed, each is the mean of two neighbours, over its own size."""
    rng = np.random.default_rng(seed)

    def part(n: int) -> FloatArray:
        white = rng.standard_normal((N_LINES + 1, n))
        return (white[1:] + white[:-1]) / np.sqrt(2) if mix else white[1:]

    return Residual((part(N_OUT) + 1j * part(N_OUT)) / np.sqrt(2), part(1), part(N_OUT))


def columns(left: Residual) -> FloatArray:
    """Return a column that is the same at all lines and one that takes turns, of length 1 each."""
    even = np.broadcast_to((-1.0) ** np.arange(N_LINES)[:, None], (N_LINES, N_OUT))
    turns = Residual((1 + 1j) / np.sqrt(2) * even, even[:, :1], even).vector(EVERY)
    both = np.column_stack([np.ones(len(left.vector(EVERY))), turns])
    return np.asarray(both / np.linalg.norm(both, axis=0))


def test_residuals_of_independent_lines_leave_errors_as_they_are() -> None:
    left = mixed(0, mix=False)
    between = LineCorrelation(left, EVERY).between(columns(left))
    # Twelve lags of up to 1500 x 6 products: each known to 1 %, their weighed sum to 5 %.
    np.testing.assert_allclose(between, np.eye(2), atol=0.2)


def test_neighbours_that_go_together_tell_less_of_what_is_alike_and_more_of_what_takes_turns() -> None:
    left = mixed(1, mix=True)
    between = LineCorrelation(left, EVERY).between(columns(left))
    # Half of a line is its neighbour's: 1 + 2 x 0.5 and 1 - 2 x 0.5, tapered.
    assert between[0, 0] == pytest.approx(1 + TAPER, abs=0.2)
    assert between[1, 1] == pytest.approx(1 - TAPER, abs=0.2)


def test_lines_that_are_left_out_are_no_neighbours() -> None:
    left, where = mixed(2, mix=True), EVERY.copy()
    where[1::2] = False
    kept = columns(left)[:, :1][
        np.asarray(
            Residual((1 + 1j) / np.sqrt(2) * where, where[:, :1] * 1.0, where * 1.0).vector(EVERY), bool
        )
    ]
    between = LineCorrelation(left, where).between(kept / np.linalg.norm(kept))
    assert between[0, 0] == pytest.approx(1.0, abs=0.2)  # every other line is independent of the next


def leaking(seed: int, *, shared: bool, loud: float = 1.0) -> Residual:
    """Return residuals of leaking records: shared, all channels of the run have the same in each line.

    Half of the lines are so many times as loud as the others.
    """
    rng = np.random.default_rng(seed)
    size = np.where(np.arange(N_LINES) < N_LINES // 2, loud, 1.0)[:, None]

    def part() -> FloatArray:
        white = rng.standard_normal((N_LINES, N_OUT))
        return np.asarray(size * (white[:, :1] + 0 * white if shared else white))

    return Residual((part() + 1j * part()) / np.sqrt(2), None, part(), lines_correlated=True)


def test_where_power_leaks_what_all_channels_share_is_known_once() -> None:
    left = leaking(0, shared=True)
    column = np.ones((len(left.vector(EVERY)), 1))
    between = LineCorrelation(left, EVERY).between(column / np.linalg.norm(column))
    # Three parts in each of 1500 lines, to 4 %; nine lags of weighed products, to 9 %: three of these.
    assert between[0, 0] == pytest.approx(N_OUT, rel=0.27)


def test_where_power_leaks_lines_that_are_louder_tell_less() -> None:
    left = leaking(1, shared=False, loud=3.0)
    lines = np.broadcast_to(np.arange(N_LINES)[:, None] < N_LINES // 2, (N_LINES, N_OUT))
    label = lines.astype(np.float64)
    early = Residual((label + 1j * label) / np.sqrt(2), None, label).vector(EVERY)
    both = np.column_stack([early, 1 - early])
    between = LineCorrelation(left, EVERY).between(both / np.linalg.norm(both, axis=0))
    # Over the mean square of all: 9 and 1 over 5.
    np.testing.assert_allclose(np.diag(between), [9 / 5, 1 / 5], rtol=0.3)


def test_leakage_that_is_in_step_far_from_its_resonance_is_seen_as_far() -> None:
    length, rng = 30, np.random.default_rng(3)

    def part() -> FloatArray:
        return np.repeat(rng.standard_normal((N_LINES // length, N_OUT)), length, axis=0)

    left = Residual((part() + 1j * part()) / np.sqrt(2), part(), part(), lines_correlated=True)
    column = np.ones((len(left.vector(EVERY)), 1)) / np.sqrt(len(left.vector(EVERY)))
    between = LineCorrelation(left, EVERY).between(column)[0, 0]
    # 600 independent numbers, known to 6 % and once more by their sums; Bartlett's window takes a quarter.
    assert 0.6 * length < between < 1.1 * length


def test_no_number_that_is_free_asks_for_no_covariance() -> None:
    # As where every number of a fit lies on one of its bounds.
    left = leaking(2, shared=False)
    assert LineCorrelation(left, EVERY).between(np.zeros((len(left.vector(EVERY)), 0))).shape == (0, 0)

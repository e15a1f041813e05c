"""What a model misses of responses, in units of its errors."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import IntArray
from modallab.fe.assembly import Assembly
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.rows import (
    Rows,
    log_ratios,
    log_rows,
    mean_square,
    model_error_share,
    reconstruction_rows,
)
from modallab.updating.responses.target import TargetResponses
from tests.service.updating.responses.cases import (
    BEAM,
    BEAM_EACH,
    BEAM_LINES,
    BEAM_SENSORS,
    exact,
    measured,
    noisy,
)

STIFFER = change(BEAM, [MemberChange((9, 10), MemberProperty.MODULUS, factor=1.2)])
LINES = BEAM_LINES[::8]
ONES = np.ones(len(BEAM_EACH.macros))


def model_of(target: TargetResponses) -> ResponseModel:
    return ResponseModel(CorrectedModel(Assembly(BEAM), BEAM_EACH), target)


def test_random_errors_alone_leave_a_mean_square_of_one() -> None:
    target = noisy(measured(BEAM, LINES, BEAM_SENSORS), 0.99, 4)
    left = float(mean_square(log_ratios(target, model_of(target).receptance(ONES)), target))
    # 440 numbers: standard deviation sqrt(2 / 440) = 0.07, three of them
    assert abs(left - 1) < 0.2


def test_log_rows_say_how_log_ratios_move() -> None:
    target = exact(measured(STIFFER, LINES, BEAM_SENSORS))
    model, small = model_of(target), 1e-6
    rows = log_rows(model, ONES)
    step = small * np.random.default_rng(1).standard_normal(len(ONES))
    after, before = (log_rows(model, ONES + sign * step).residual for sign in (1, -1))
    moved = rows.matrix @ step
    # central differences: rounding of a log ratio, 1e-10 over its error of 1e-6, and what is of third order
    np.testing.assert_allclose((before - after) / 2, moved, atol=1e-4 * np.abs(moved).max())


def test_a_model_that_misses_nothing_is_not_doubted() -> None:
    assert model_error_share(model_of(noisy(measured(BEAM, LINES, BEAM_SENSORS), 0.9, 4)), ONES) < 1e-3
    assert model_error_share(model_of(exact(measured(BEAM, LINES, BEAM_SENSORS))), ONES) == 0.0


def test_a_wrong_model_is_doubted_until_what_it_misses_is_explained() -> None:
    model = model_of(noisy(measured(STIFFER, LINES, BEAM_SENSORS), 0.99, 4))
    wrong = model_error_share(model, ONES)
    assert wrong > 1e-4
    rows = reconstruction_rows(model, ONES, wrong)
    # the share is the one at which the mean square is 1: the root is found to 1e-12
    assert abs(np.mean(rows.residual**2) - 1) < 1e-6


def test_a_model_taken_for_right_has_the_rows_of_plain_differences() -> None:
    model = model_of(exact(measured(STIFFER, LINES, BEAM_SENSORS)))
    rows = reconstruction_rows(model, ONES, 0.0)
    (fields,) = model.fields(ONES)
    target = model.target
    least = 1e-3 * target.errors * target.sizes[:, None]
    error = np.hypot(np.abs(target.values) * target.errors, least)
    missed = (target.values - fields.receptance) / error
    plain = fields.derivatives(fields.driven) / error[..., None]
    # the same sums of squares and products in other directions: what a least squares solution hangs on
    gram = np.tensordot(plain.conj(), plain, ([0, 1, 2], [0, 1, 2])).real
    np.testing.assert_allclose(rows.matrix.T @ rows.matrix, gram, rtol=1e-6, atol=1e-9 * np.abs(gram).max())
    assert np.isclose((rows.residual**2).sum(), (np.abs(missed) ** 2).sum(), rtol=1e-9)


def test_what_is_not_used_has_no_rows() -> None:
    target = exact(measured(STIFFER, LINES, BEAM_SENSORS))
    used = target.used.copy()
    used[:, 3] = False
    less = replace(target, used=used)
    for rows in (reconstruction_rows(model_of(less), ONES, 1e-2), log_rows(model_of(less), ONES)):
        assert len(rows.residual) == less.n_numbers
    picked = [i for i in range(len(BEAM_SENSORS)) if i != 3]
    without = replace(
        target,
        values=target.values[:, picked],
        errors=target.errors[:, picked],
        used=target.used[:, picked],
        common=target.common[:, picked],
        outputs=tuple(BEAM_SENSORS[i] for i in picked),
    )
    for wrong in (1e-3, 1e-1):
        left, alone = (reconstruction_rows(model_of(one), ONES, wrong) for one in (less, without))
        gram = alone.matrix.T @ alone.residual
        np.testing.assert_allclose(left.matrix.T @ left.residual, gram, atol=1e-6 * np.abs(gram).max())


def _blocks(line: IntArray, numbers: int) -> list[int]:
    return list(map(int, Rows(np.zeros((len(line), 1)), np.zeros(len(line)), line).blocks(numbers)))


def test_bands_are_of_whole_lines() -> None:
    line = np.repeat(np.arange(4), 3)
    assert _blocks(line, 6) == [0] * 6 + [1] * 6
    assert _blocks(line, 100) == [0] * 12
    assert _blocks(line, 1) == line.tolist()

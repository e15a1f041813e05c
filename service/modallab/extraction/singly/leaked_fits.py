"""Fits of leaked lines, with errors that know how leakage was undone, and what it may have left."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.extraction.measured.leakage import LEFT, Leakage
from modallab.extraction.singly.fitting import Data, Settled, Table, fit_once, undoing
from modallab.extraction.singly.laws import Law
from modallab.extraction.singly.leakage_feedback import Feedback, feedback
from modallab.extraction.singly.method import ExtractionMethod
from modallab.extraction.singly.screening import Screening, screen

UNSETTLED = 5.0  # strength of feedback at which fits differ by where they began, as on a line's own centre


def allowing_for_leakage(
    method: ExtractionMethod, law: Law, data: Data, leakage: Leakage, settled: Settled
) -> Settled:
    """Return fits whose errors hold what the undoing of leakage makes of them, and with the bias left.

    Lines were corrected by the modes fitted to them, so that an error of a mode makes itself true in part:
    see `Feedback`. Fits with so much of it that they might as well be others do not count
    where there are any without.

    Parameters
    ----------
    method, law, data
        As of `fit_all`.
    settled
        What it returned.
    """
    now = fit_once(method, law, data, settled.cleaned)
    beside = now.rest + settled.others

    def refit(eigenvalue: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        by = replace(now, eigenvalue=eigenvalue)
        lines = data.receptance * undoing(law, data, leakage, by, beside) - settled.others
        again = fit_once(method, law, data, lines)
        return again.eigenvalue, again.table.modal_constant

    raw = fit_once(method, law, data, data.receptance - settled.others).table
    back = feedback(refit, now.eigenvalue)
    table = _widened(settled.table, back)
    bias = _left_over(table, back, _moved(table, raw, data.spacing))
    screening = _screened(settled.table, table, back.strength < UNSETTLED, data.spacing)
    return replace(settled, table=replace(table, screening=screening, leakage_bias=bias))


def _widened(table: Table, back: Feedback) -> Table:
    part = table.frequency_error * 8 * np.pi**2 * table.frequency
    return replace(
        table,
        frequency_error=table.frequency_error * back.widening[:, :, 0],
        loss_factor_error=table.loss_factor_error * back.widening[:, :, 1],
        modal_constant_error=np.hypot(table.modal_constant_error, part * back.constant_error),
    )


def _moved(table: Table, raw: Table, spacing: float) -> FloatArray:
    """Return by what leakage moves frequency, Hz, and loss factor, (n_modes, n_frf, 2).

    At most, and where lines as they are show no mode, to a line's centre and to its width.
    """
    both = (table.frequency > 0) & (raw.frequency > 0)
    line = spacing / np.where(table.frequency > 0, table.frequency, spacing)
    away = np.where(both, np.abs(raw.frequency - table.frequency), np.inf)
    damped = np.where(both, np.abs(raw.loss_factor - table.loss_factor), np.inf)
    return np.stack([np.minimum(away, spacing / 2), np.minimum(damped, line)], axis=2)


def _left_over(table: Table, back: Feedback, moved: FloatArray) -> FloatArray:
    """Return what may be left of bias, as `moved`.

    What feedback makes of the part that the correction leaves, of a mode that is not settled in most FRFs
    all of it; what further rounds would change; and that the mean of numbers which scatter by a part e of
    themselves about a non-linear law is off by a part e^2.
    """
    frequency, loss_factor = table.frequency, table.loss_factor
    found = frequency > 0
    adrift = (found & (back.strength >= UNSETTLED)).sum(axis=1) > found.sum(axis=1) / 2
    left = np.maximum(LEFT * (back.strength - 1), adrift[:, None])[:, :, None] * moved
    relative = np.where(found, table.loss_factor_error / np.where(found, loss_factor, 1.0), 0.0)
    curved = (relative**2)[:, :, None] * np.stack([loss_factor * frequency / 2, loss_factor], axis=2)
    stiffness = (2 * np.pi * np.where(found, frequency, 1.0)) ** 2
    rest = back.remainder / stiffness
    unfinished = np.stack([np.abs(rest.real) * frequency / 2, np.abs(rest.imag)], axis=2)
    return np.asarray(left + curved + unfinished)


def _screened(before: Table, table: Table, settled: BoolArray, spacing: float) -> Screening:
    """Return verdicts by the wider errors; for a mode of which nothing would be left, as before."""
    found = (table.frequency > 0) & settled
    errors = table.frequency_error, table.loss_factor_error
    after = screen(table.frequency, table.loss_factor, *errors, found, spacing)
    some = after.good.any(axis=1, keepdims=True)
    return Screening(
        good=np.where(some, after.good, before.screening.good),
        unsure=np.where(some, after.unsure, before.screening.unsure),
        outlying=np.where(some, after.outlying, before.screening.outlying),
    )

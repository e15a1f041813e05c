"""Fits of leaked lines, with errors that know how leakage was undone, and what it may have left."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.settings import LEAKAGE
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import Data, Settled, Table, fit_once, undoing
from modallab.extraction.single_mode.leakage_feedback import LeakageFeedback, feedback
from modallab.extraction.single_mode.leaked_covariance import LineSpectra, leaked_covariance
from modallab.extraction.single_mode.method import ExtractionMethod
from modallab.extraction.single_mode.residual_bias import moved_by_rest
from modallab.extraction.single_mode.screening import Screening, screen

UNSETTLED = 5.0  # strength of feedback at which fits differ by where they began, as on a line's own centre


def allowing_for_leakage(
    method: ExtractionMethod,
    law: DampingModel,
    data: Data,
    leakage: WindowLeakage,
    settled: Settled,
    known: LineSpectra | None,
) -> Settled:
    """Return fits whose errors hold what the undoing of leakage makes of them, and with the bias left.

    Lines were corrected by the modes fitted to them, so that an error of a mode makes itself true in part:
    see `LeakageFeedback`. Fits with so much of it that they might as well be others do not count
    where there are any without.

    Parameters
    ----------
    method, law, data
        As of `fit_all`.
    settled
        What it returned.
    known
        How exact the lines are; None where no coherence tells it.
    """
    kind = settled.inertance
    now = fit_once(method, law, data, settled.cleaned, kind)
    beside = now.rest + settled.others

    def refit(eigenvalue: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        by = replace(now, eigenvalue=eigenvalue)
        lines = data.receptance * undoing(law, data, leakage, by, beside) - settled.others
        again = fit_once(method, law, data, lines, kind)
        return again.eigenvalue, again.table.modal_constant

    raw = fit_once(method, law, data, data.receptance - settled.others, kind).table
    back = feedback(refit, now.eigenvalue)
    held = leaked_covariance(method, law, data, leakage, now, settled.others, known)
    rest = moved_by_rest(method, law, data, settled, now)
    held = held * now.widened[..., None, None] ** 2 + rest[..., :, None] * rest[..., None, :]
    table = _with_errors(settled.table, back.settled(held))
    bias = _left_over(table, back, _moved(table, raw, data.spacing))
    screening = _screened(settled.table, table, back.strength < UNSETTLED, data.spacing)
    return replace(settled, table=replace(table, screening=screening, leakage_bias=bias))


def _with_errors(table: Table, covariance: FloatArray) -> Table:
    """Return the table with errors from the covariance of each fit, (n_modes, n_frf, 4, 4).

    The error of a modal constant is that of its size. Lines that say nothing of a fit leave it as it was.
    """
    found, good = table.frequency > 0, table.screening.good
    frequency, loss_factor = np.where(found, table.frequency, 1.0), table.loss_factor
    stiffness = (2 * np.pi * frequency) ** 2
    nothing, one = np.zeros_like(frequency), np.ones_like(frequency)
    size = np.abs(table.modal_constant)
    turn = table.modal_constant / np.where(size > 0, size, 1.0)

    def error(*slope: FloatArray) -> FloatArray:
        along = np.stack(slope, axis=-1)
        return np.asarray(np.sqrt(np.maximum(np.einsum("...p,...pq,...q", along, covariance, along), 0.0)))

    frequency_error = error(one, nothing, nothing, nothing) / (8 * np.pi**2 * frequency)
    loss_factor_error = error(-loss_factor, one, nothing, nothing) / stiffness
    of_size = error(nothing, nothing, turn.real, turn.imag)
    told = found & (frequency_error > 0) & (loss_factor_error > 0)
    return replace(
        table,
        frequency_error=np.where(told, frequency_error, table.frequency_error),
        loss_factor_error=np.where(told, loss_factor_error, table.loss_factor_error),
        modal_constant_error=np.where(told & good & (of_size > 0), of_size, table.modal_constant_error),
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


def _left_over(table: Table, back: LeakageFeedback, moved: FloatArray) -> FloatArray:
    """Return what may be left of bias, as `moved`.

    What feedback makes of the part that the correction leaves, of a mode that is not settled in most FRFs
    all of it; what further rounds would change; and that the mean of numbers which scatter by a part e of
    themselves about a non-linear law is off by a part e^2.
    """
    frequency, loss_factor = table.frequency, table.loss_factor
    found = frequency > 0
    adrift = (found & (back.strength >= UNSETTLED)).sum(axis=1) > found.sum(axis=1) / 2
    left = np.maximum(LEAKAGE.remaining_fraction * (back.strength - 1), adrift[:, None])[:, :, None] * moved
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

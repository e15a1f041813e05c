"""Shifts of natural frequencies and loss factors between measurement and model."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.diagnosis.localisation.settings import MODE_SHIFTS
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.result_localisation import ModeShift


def mode_shifts(
    predictor: SingleTestPredictor, h: ComplexArray, modes: Sequence[int], start_shifts: Sequence[float]
) -> tuple[ModeShift, ...]:
    """Return the shifts of some modes with their standard errors.

    Near a resonance the FRF of each response is represented as one mode and a straight line in omega^2
    (residual of the other modes). Its pole is fitted by least squares to the measurement and, at the same
    lines with the same errors, to the prediction, so that window and mass loading affect both alike. The
    shift is the ratio of the two poles, averaged over the responses with the inverse variance as weight.
    Sanathanan and Koerner (1963), IEEE Trans. Automatic Control 8, 56-58.

    Parameters
    ----------
    h
        (n_freq, n_out), predicted FRFs.
    modes
        Elastic modes of the model, counted from 1.
    start_shifts
        Approximate relative frequency shift of each mode.
    """
    basis = predictor.modes()
    shifts = []
    for mode, start_shift in zip(modes, start_shifts, strict=True):
        frequency, loss = float(basis.frequencies[mode - 1]), float(basis.loss_factors[mode - 1])
        predicted = _poles(predictor.observed, h, frequency, loss)
        measured = _poles(predictor.observed, predictor.observed.h, frequency * (1 + start_shift), loss)
        shifts.append(ModeShift(mode, frequency, *_shift_of_poles(predicted, measured)))
    return tuple(shifts)


def _shift_of_poles(
    predicted: tuple[ComplexArray, FloatArray], measured: tuple[ComplexArray, FloatArray]
) -> tuple[float, float, float, float]:
    """Return the mean shifts of natural frequency and loss factor, each with its standard error."""
    (p, p_error), (q, q_error) = predicted, measured
    valid = np.isfinite(p_error) & np.isfinite(q_error) & (p.real > 0) & (q.real > 0)
    if not valid.any():
        return np.nan, np.nan, np.nan, np.nan
    p, q, spread = p[valid], q[valid], np.hypot(p_error[valid], q_error[valid])
    shift, shift_error = _mean(np.sqrt(q.real / p.real) - 1, spread / 2)
    loss = p.imag / p.real
    if not (loss > 0).all():
        return shift, shift_error, np.nan, np.nan
    return shift, shift_error, *_mean(q.imag / q.real / loss - 1, spread / loss)


def _mean(values: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Return the weighted mean and its standard error.

    The standard error follows from the stated errors or, if that is larger, from the scatter of the values.
    """
    weight = 1 / errors**2
    mean = float((weight * values).sum() / weight.sum())
    reduced_chi_square = float((weight * (values - mean) ** 2).sum()) / max(len(values) - 1, 1)
    return mean, float(np.sqrt(max(1.0, reduced_chi_square) / weight.sum()))


def _poles(
    observed: Observed, h: ComplexArray, frequency: float, loss: float
) -> tuple[ComplexArray, FloatArray]:
    """Return the poles omega_r^2 (1 + i eta), (rad/s)^2, near a frequency, with relative errors, (n_out,).

    Both are nan where a response does not show the mode.
    """
    spacing = float(np.diff(observed.freq).min())
    reach = max(MODE_SHIFTS.reach * loss * frequency, MODE_SHIFTS.fewest_lines * spacing)
    near = np.abs(observed.freq - frequency) < reach
    x = (observed.freq[near] / frequency) ** 2
    values, error = h[near].T, np.hypot(observed.error[near], MODE_SHIFTS.model_error).T
    usable = observed.usable[near].T
    if len(x) < 2 * MODE_SHIFTS.fewest_lines - 1:
        missing = np.full(len(values), np.nan)
        return missing.astype(complex), missing
    pole, spread, redundancy = _fit_pole(x, values, error, usable, loss)
    limit = MODE_SHIFTS.largest_shift
    valid = (redundancy > 0) & (np.abs(pole - 1) < limit) & (spread > 0) & (spread < limit)
    unit = (2 * np.pi * frequency) ** 2
    return np.where(valid, pole * unit, np.nan), np.where(valid, spread, np.nan)


def _fit_pole(
    x: FloatArray, values: ComplexArray, error: FloatArray, usable: BoolArray, loss: float
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Return pole, its standard error and the number of redundant lines of each response, (n_out,).

    Least squares of h (p - x) = n_0 + n_1 x, divided by the error of its left side (Sanathanan and Koerner).

    Parameters
    ----------
    x
        (n_line,) squared frequency over the squared resonance frequency.
    values, error, usable
        (n_out, n_line) FRF, its relative error, and which lines are usable.
    loss
        Loss factor of the starting pole.
    """
    n_out = len(values)
    magnitude = np.where(usable, np.abs(values), 1.0)
    pole = np.full(n_out, 1 + 1j * max(loss, MODE_SHIFTS.least_loss_factor), complex)
    line = np.broadcast_to(np.stack([-np.ones_like(x), -x], axis=1), (n_out, len(x), 2))
    rows = np.concatenate([values[..., None], line], axis=2)
    for _ in range(MODE_SHIFTS.iterations):
        weight = np.where(usable, 1 / (error * magnitude * np.abs(pole[:, None] - x)), 0.0)
        inverse = np.linalg.pinv(rows * weight[..., None])
        solution = inverse @ (weight * values * x)[..., None]
        pole = solution[:, 0, 0]
    residual = weight * (values * x - (rows @ solution)[..., 0])
    redundancy = usable.sum(axis=1) - 3  # 3 complex unknowns
    # `error` is that of the real part, so a squared magnitude has twice its variance.
    scale = (np.abs(residual) ** 2).sum(axis=1) / (2 * np.maximum(redundancy, 1))
    spread = np.sqrt(np.maximum(scale, 1.0) * (np.abs(inverse[:, 0]) ** 2).sum(axis=1))
    return pole, spread, redundancy

"""Single-mode fits of every mode in every FRF, with the other modes subtracted iteratively."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.progress import Progress, silent
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits, FitIteration, FitTable
from modallab.extraction.single_mode.leakage_correction import leakage_corrections
from modallab.extraction.single_mode.method import ExtractionMethod, ModeFits
from modallab.extraction.single_mode.screening import screen
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT


def fit_all(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    fixed_modes: ComplexArray | float = 0.0,
    progress: Progress = silent,
    inertance: BoolArray | None = None,
) -> ConvergedFits:
    """Return the fits of every mode in every FRF.

    Each window is fitted with a single mode and a constant; then the other modes are subtracted from every
    window and the fits are repeated. The constant represents residuals of modes outside the range: rigid-body
    modes are a constant in inertance, higher modes in receptance. Both kinds are fitted and each mode keeps
    the one with the smaller misfit; in inertance, too, a mode is a pole and a constant. In an FRF that does
    not show a mode, its modal constant follows from linear least squares at the mean eigenvalue of the other
    FRFs.

    Parameters
    ----------
    method, damping_model
        Single-mode method and damping law.
    data
        From `window_data`.
    fixed_modes
        (n_modes, n_frf, n_lines) receptance of modes that are not fitted, m/N.
    progress
        Called at every iteration.
    inertance
        (n_modes,) True where a mode is to be fitted to inertance; None: the kind with the smaller misfit.
    """
    other_modes = np.zeros_like(data.receptance) + fixed_modes
    correction = np.ones_like(data.receptance)
    n_iterations = SINGLE_MODE_FIT.iterations if data.leakage is None else SINGLE_MODE_FIT.leaked_iterations
    for n in range(n_iterations):
        progress(n / (n_iterations + 1), f"round {n + 1} of {n_iterations + 1}")
        iteration = fit_once(
            method, damping_model, data, data.receptance * correction - other_modes, inertance
        )
        other_modes = (
            _other_modes(damping_model, data, iteration.table.modal_constant, iteration.eigenvalue)
            + fixed_modes
        )
        if data.leakage is not None:
            new_correction = leakage_corrections(
                damping_model, data, data.leakage, iteration, iteration.residual + other_modes
            )
            share = 1.0 if n < SINGLE_MODE_FIT.leaked_iterations // 2 else SINGLE_MODE_FIT.late_step
            correction = (1 - share) * correction + share * new_correction
    # the lines are free of leakage after correction
    cleaned = data.receptance * correction - other_modes
    final = fit_once(method, damping_model, replace(data, leakage=None), cleaned, inertance)
    return ConvergedFits(final.table, cleaned, other_modes, final.inertance)


def fit_once(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    target: ComplexArray,
    inertance: BoolArray | None = None,
    *,
    screened: bool = True,
) -> FitIteration:
    """Return a mode and a constant fitted to every window of `target`, (n_modes, n_frf, n_lines) m/N.

    Other parameters as in `fit_all`.

    Parameters
    ----------
    screened
        Whether fits that are not good have the mean eigenvalue of the others; with leakage none has.
    """
    n_modes, n_frf, n_lines = data.freq.shape
    selection = slice(None) if inertance is None else (inertance.astype(np.int64), np.arange(n_modes))
    frf = np.stack([target, -data.x * target])[selection]
    weight = np.stack(
        [data.weight, data.weight / np.maximum(data.x, SINGLE_MODE_FIT.smallest_eigenvalue) ** 2]
    )[selection]
    rows = (frf.size // n_lines, n_lines)
    freq = np.broadcast_to(data.freq, frf.shape)
    order = np.repeat([0, 2], n_modes * n_frf) if inertance is None else np.repeat(2 * inertance, n_frf)
    fits = damping_model.fit(method, freq.reshape(rows), frf.reshape(rows), weight.reshape(rows), order)
    if inertance is None:
        kind = _better_kind(np.where(fits.found, fits.misfit, np.inf).reshape(2, n_modes, n_frf))
        first = kind * n_modes + np.arange(n_modes)
    else:
        kind, first = inertance.astype(np.int64), np.arange(n_modes)
    pick = first[:, None] * n_frf + np.arange(n_frf)
    lines = frf.reshape(rows)[pick], weight.reshape(rows)[pick]
    screened = screened and data.leakage is None  # the leakage of a line is that of its own fit, good or not
    return _tabulate(damping_model, data, fits, pick, *lines, kind == 1, screened=screened)


def _better_kind(misfit: FloatArray) -> IntArray:
    """Return the kind with the lower median misfit, 0 or 1, (n_modes,); `misfit` (2, n_modes, n_frf)."""
    middle = np.sort(misfit, axis=2)[:, :, (misfit.shape[2] - 1) // 2]
    better: IntArray = (middle[1] < middle[0]).astype(np.int64)
    return better


def _tabulate(
    damping_model: DampingModel,
    data: FitData,
    fits: ModeFits,
    pick: IntArray,
    frf: ComplexArray,
    weight: FloatArray,
    inertance: BoolArray,
    *,
    screened: bool,
) -> FitIteration:
    """Return the iteration of `fit_once` from the selected fits, (n_modes, n_frf), and their lines."""
    misfit_factor = np.sqrt(np.maximum(fits.misfit[pick], 1))
    frequency, loss_factor = fits.frequency[pick], fits.loss_factor[pick]
    errors = fits.frequency_error[pick] * misfit_factor, fits.loss_factor_error[pick] * misfit_factor
    screening = screen(frequency, loss_factor, *errors, fits.found[pick], data.spacing)
    identified = fits.found[pick]
    # before neighbours and leakage are removed, perhaps no fit is good: all identified ones serve until then
    good = np.where(screening.good.any(axis=1, keepdims=True), screening.good, identified)
    fitted_eigenvalue = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
    n_good = good.sum(axis=1, keepdims=True)
    mean_eigenvalue = (good * fitted_eigenvalue).sum(axis=1, keepdims=True) / np.maximum(n_good, 1)
    if not screened:
        good = identified
    eigenvalue = np.where(good, fitted_eigenvalue, np.where(n_good > 0, mean_eigenvalue, 1j))
    # back from inertance: divide the response by -omega^2, the modal constant by that at the pole
    factor = np.where(inertance[:, None, None], -np.maximum(data.x, SINGLE_MODE_FIT.smallest_eigenvalue), 1)
    divisor = np.where(inertance[:, None], -damping_model.pole(eigenvalue, eigenvalue)[0], 1)
    shape = damping_model.response(data.freq, eigenvalue[:, :, None], np.ones(1, complex))
    linear_constant, linear_error = _constant_at_eigenvalue(frf, weight, factor * shape)
    constant = np.where(good, fits.modal_constant[pick] / divisor, linear_constant) * (n_good > 0)
    error = np.where(good, fits.modal_constant_error[pick] * misfit_factor / np.abs(divisor), linear_error)
    mode = damping_model.response(data.freq, eigenvalue[:, :, None], constant[:, :, None])
    total = weight.sum(axis=2, keepdims=True)
    residual = (weight * (frf - factor * mode)).sum(axis=2, keepdims=True) / np.where(total > 0, total, 1)
    table = FitTable(frequency, loss_factor, constant, *errors, error, screening)
    return FitIteration(table, eigenvalue, residual / factor, inertance, misfit_factor)


def _constant_at_eigenvalue(
    frf: ComplexArray, weight: FloatArray, shape: ComplexArray
) -> tuple[ComplexArray, FloatArray]:
    """Return modal constants and errors, (n_modes, n_frf), of modes of frequency response `shape`."""
    total = weight.sum(axis=2, keepdims=True)
    share = weight / np.where(total > 0, total, 1)
    shape = shape - (share * shape).sum(axis=2, keepdims=True)
    flat = frf - (share * frf).sum(axis=2, keepdims=True)
    power = (weight * np.abs(shape) ** 2).sum(axis=2)
    safe = np.where(power > 0, power, np.inf)
    constant = (weight * shape.conj() * flat).sum(axis=2) / safe
    remainder = flat - constant[:, :, None] * shape
    misfit = (weight * np.abs(remainder) ** 2).sum(axis=2) / np.maximum((weight > 0).sum(axis=2) - 2, 1)
    return constant, np.sqrt(np.maximum(misfit, 1) / 2 / safe)


def _other_modes(
    damping_model: DampingModel, data: FitData, constant: ComplexArray, eigenvalue: ComplexArray
) -> ComplexArray:
    """Return the receptance of all other modes in every window, (n_modes, n_frf, n_lines)."""
    total = np.zeros_like(data.receptance)
    for m in range(
        len(constant)
    ):  # all in one array would need memory proportional to the squared number of modes
        mode = damping_model.response(data.freq, eigenvalue[m][:, None], constant[m][:, None])
        mode[m] = 0
        total += mode
    return total

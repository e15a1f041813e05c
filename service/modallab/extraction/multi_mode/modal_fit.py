"""Fit of all modes to all FRFs by variable projection, with covariance."""

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.numerics import EIGENVALUE_ROUNDING, SAFE_DIVISOR, SUM_ROUNDING
from modallab.core.progress import Progress, part, silent
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.fit_settings import MODAL_FIT
from modallab.extraction.multi_mode.modal_covariance import parameter_weights, uncertainty, unit_diagonal
from modallab.extraction.multi_mode.participation import SharedShapeBasis
from modallab.extraction.multi_mode.physical_units import constants, to_physical_units
from modallab.extraction.multi_mode.pole_basis import BASES, PoleBasis
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
    scale_lines,
    solve_linear,
    with_similar_weights,
)
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.noise_model import INDEPENDENT_LINES, NoiseModel


def fit_modes(
    freq: FloatArray,
    receptance: ComplexArray,
    weight: FloatArray,
    start: ComplexArray,
    *,
    damping: Damping = Damping.STRUCTURAL,
    participation: ComplexArray | None = None,
    noise: NoiseModel = INDEPENDENT_LINES,
    progress: Progress = silent,
) -> ModalFit:
    """Return all modes in all FRFs, with residuals, from eigenvalues to start at.

    Separable least squares: modal constants and residuals are eliminated (at fixed eigenvalues they are the
    least-squares frequency-domain solution), and the eigenvalues follow by the Levenberg-Marquardt method,
    with derivatives by Kaufman's form of the variable projection.

    Parameters
    ----------
    freq
        (n_lines,) Hz, above 0, in any spacing.
    receptance
        (n_lines, n_frf) m/N, of several references DoF by DoF.
    weight
        (n_lines, n_frf) one over E|error|^2; 0 leaves a line out.
    start
        (n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2.
    damping
        Damping model.
    participation
        (n_modes, n_ref) initial participation factors: the modal constants of a mode are then products
        `psi_j L_k`, and as many modes as references may coincide. None if each FRF has its own constant.
    noise
        Common errors of the lines, for the standard errors.
    progress
        Receives the progress by iterations.

    References
    ----------
    Golub, G. H. and Pereyra, V. (1973), SIAM Journal on Numerical Analysis 10, 413-432.
    Kaufman, L. (1975), BIT 15, 49-57.
    """
    n_ref = 1 if participation is None else participation.shape[1]
    lines = scale_lines(2 * np.pi * freq, receptance, weight, n_ref, noise)
    order = np.argsort(start, kind="stable")
    reach = None if participation is None or n_ref == 1 else participation[order]
    basis, begin = _begin(start[order] / lines.unit**2, reach, damping)
    similar = with_similar_weights(lines)
    if similar is not None:
        begin, _ = _descend(similar, basis, begin, part(progress, 0.0, MODAL_FIT.similar_share))
        progress = part(progress, MODAL_FIT.similar_share, 1.0)
    parameters, linear = _descend(lines, basis, begin, progress)
    order = np.argsort(parameters[:, 0], kind="stable")
    if (np.diff(order) < 0).any():  # modes have changed places
        parameters, basis = parameters[order], basis.at(order)
        linear = solve_linear(lines, basis, parameters)
    return to_physical_units(lines, basis, parameters, linear, uncertainty(lines, basis, parameters, linear))


def one_step(
    freq: FloatArray, receptance: ComplexArray, weight: FloatArray, fit: ModalFit, *, damping: Damping
) -> tuple[ComplexArray, ComplexArray]:
    """Return the modes after one Gauss-Newton step, as their response to small changes of the lines.

    Parameters
    ----------
    freq, receptance, weight, damping
        As in `fit_modes`, with slightly changed lines.
    fit
        Result of `fit_modes` for the original lines.

    Returns
    -------
    Eigenvalues, (n_modes,) (rad/s)^2, and modal constants, (n_modes, n_frf) 1/kg.
    """
    n_ref = 1 if fit.participation is None else fit.participation.shape[1]
    lines = scale_lines(2 * np.pi * freq, receptance, weight, n_ref)
    basis, parameters = _begin(fit.eigenvalue / lines.unit**2, fit.participation, damping)
    normal, slope = _normal_equations(basis, solve_linear(lines, basis, parameters))
    step = _step(normal, slope, 0.0).reshape(parameters.shape)
    # the data hardly determine a mode far outside the range
    parameters = parameters + _limited(step, parameters, (float(lines.omega.min()) ** 2, 1.0))
    constant = constants(lines, basis, parameters, solve_linear(lines, basis, parameters))
    stiffness = lines.unit**2 * parameters[:, 0]
    return np.asarray(stiffness * (1 + 1j * basis.loss_factor(parameters)[0])), constant


def _begin(
    eigenvalue: ComplexArray, participation: ComplexArray | None, damping: Damping
) -> tuple[PoleBasis, FloatArray]:
    """Return the basis and the initial parameters, (n_modes, n_parameters)."""
    law = BASES[damping]
    if participation is None:
        return law, law.parameters(eigenvalue)
    basis = SharedShapeBasis(damping, np.abs(participation).argmax(axis=1), participation.shape[1])
    return basis, basis.start(law.parameters(eigenvalue), participation)


def modes_at_eigenvalues(
    freq: FloatArray,
    receptance: ComplexArray,
    weight: FloatArray,
    eigenvalue: ComplexArray,
    *,
    damping: Damping = Damping.STRUCTURAL,
) -> ModalFit:
    """Return modal constants and residuals at given eigenvalues; parameters as in `fit_modes`.

    Linear least squares in the frequency domain (LSFD). The covariance of the eigenvalues is that of a fit
    linearised at the given values.
    """
    basis = BASES[damping]
    lines = scale_lines(2 * np.pi * freq, receptance, weight)
    parameters = basis.parameters(np.sort_complex(eigenvalue) / lines.unit**2)
    linear = solve_linear(lines, basis, parameters)
    return to_physical_units(lines, basis, parameters, linear, uncertainty(lines, basis, parameters, linear))


def fitted_receptance(fit: ModalFit, freq: FloatArray, damping: Damping) -> ComplexArray:
    """Return the receptance resynthesised from a fit with residuals, (n_lines, n_frf) m/N.

    Parameters
    ----------
    freq
        (n_lines,) Hz, above 0.
    damping
        Damping model of the fit.
    """
    basis = BASES[damping]
    omega = 2 * np.pi * freq
    parameters = basis.parameters(fit.eigenvalue)
    parts = np.stack([fit.modal_constant.real, fit.modal_constant.imag], axis=2)
    coefficients = np.linalg.inv(basis.constant(parameters)) @ parts[..., None]
    columns = basis.columns(omega, parameters).reshape(len(freq), -1)
    modes = columns @ coefficients[..., 0].swapaxes(1, 2).reshape(-1, fit.modal_constant.shape[1])
    mass_line, stiffness_line = fit.residuals
    if fit.fixed_eigenvalue is not None and fit.fixed_constant is not None:
        modes = modes + 1 / (fit.fixed_eigenvalue - omega[:, None] ** 2) @ fit.fixed_constant
    return np.asarray(modes + stiffness_line - mass_line / omega[:, None] ** 2, complex)


def _descend(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, progress: Progress
) -> tuple[FloatArray, LinearSolution]:
    """Return the parameters of least misfit and the linear solution there."""
    linear = solve_linear(lines, basis, parameters)
    damping, limits = MODAL_FIT.first_damping, (float(lines.omega.min()) ** 2, 1.0)
    n_spare = max(2 * int((lines.weight > 0).sum()) - linear.coefficients.size - parameters.size, 1)
    below, above = _outside(parameters, limits)
    for n in range(MODAL_FIT.iterations):
        progress(n / (n + MODAL_FIT.usual_iterations), "fitting all modes to all FRFs")
        normal, slope = _normal_equations(basis, linear)
        step = _bounded_step(normal, slope, damping, parameters, limits, basis)
        misfit = float(linear.misfit.sum())
        error = _standard_errors(normal, misfit / n_spare).reshape(parameters.shape)
        size = np.abs(step) / np.maximum(error, SAFE_DIVISOR)
        size[np.abs(step) <= EIGENVALUE_ROUNDING * parameters[:, :1]] = 0.0
        # modes outside the range are residual terms, so ill determined that some drift for ever
        inside = size[~(below | above)].max(initial=0.0)
        residual_gain = _predicted_gain(step, normal, slope) > MODAL_FIT.residual_gain * misfit
        if inside < MODAL_FIT.convergence and not (residual_gain and size.max() > MODAL_FIT.convergence):
            break
        trial_solution = solve_linear(lines, basis, parameters + step)
        gain = misfit - float(trial_solution.misfit.sum())
        if abs(gain) < MODAL_FIT.insensitivity * misfit:
            break
        if gain > 0:
            parameters, linear, damping = (
                parameters + step,
                trial_solution,
                damping * MODAL_FIT.damping_decrease,
            )
            enough = max(MODAL_FIT.smallest_gain / n_spare, MODAL_FIT.residual_gain)
            # errors of coincident modes have no bound, so that no step of theirs is known to be the last
            if lines.n_references == 1 and inside < MODAL_FIT.last_step and gain < enough * misfit:
                break
        else:
            damping = max(damping, MODAL_FIT.first_damping) * MODAL_FIT.damping_increase
            if damping > 1 / MODAL_FIT.first_damping**2:  # rounding: no smaller step does better
                break
    return parameters, linear


def _bounded_step(
    normal: FloatArray,
    slope: FloatArray,
    damping: float,
    parameters: FloatArray,
    limits: tuple[float, float],
    basis: PoleBasis,
) -> FloatArray:
    """Return the Levenberg-Marquardt step, cut at the bounds of the parameters, (n_modes, n_parameters)."""
    step = _limited(_step(normal, slope, damping).reshape(parameters.shape), parameters, limits)
    return _bounded(parameters + step, parameters, limits, basis) - parameters


def _bounded(
    trial: FloatArray, parameters: FloatArray, limits: tuple[float, float], basis: PoleBasis
) -> FloatArray:
    """Return the parameters with frequency and damping inside their bounds.

    Modes outside the range stay there, because they represent out-of-band modes.
    """
    below, above = _outside(parameters, limits)
    lowest = np.where(above, limits[1], MODAL_FIT.lowest_frequency**2 * limits[0])
    highest = np.where(below, limits[0], MODAL_FIT.highest_frequency**2 * limits[1])
    bounded = trial.copy()
    bounded[:, 0] = np.clip(trial[:, 0], lowest, highest)
    largest_damping = basis.largest_damping(bounded)
    bounded[:, 1] = np.clip(trial[:, 1], -largest_damping, largest_damping)
    return bounded


def _normal_equations(basis: PoleBasis, linear: LinearSolution) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix of all parameters and its right-hand side."""
    c = parameter_weights(basis, linear)
    normal = np.einsum("jps,jsq->pq", c @ linear.projected, c.swapaxes(1, 2), optimize=True)
    return normal, np.einsum("jps,js->p", c, linear.gradient)


def _step(normal: FloatArray, slope: FloatArray, damping: float) -> FloatArray:
    even, length = unit_diagonal(normal)
    pull = np.where(np.diag(normal) > 0, slope / length, 0.0)
    return np.asarray(np.linalg.solve(even + (damping + SUM_ROUNDING) * np.eye(len(length)), pull) / length)


def _outside(parameters: FloatArray, limits: tuple[float, float]) -> tuple[BoolArray, BoolArray]:
    """Return which modes are below the range or at its first line, and which above it or at its last line."""
    stiffness = parameters[:, 0]
    return stiffness <= limits[0] * (1 + SUM_ROUNDING), stiffness >= limits[1] * (1 - SUM_ROUNDING)


def _standard_errors(normal: FloatArray, variance: float) -> FloatArray:
    """Return the standard errors of all parameters, infinite where rounding leaves none."""
    even, length = unit_diagonal(normal)
    share = np.diag(np.linalg.inv(even + SUM_ROUNDING * np.eye(len(length))))
    return np.asarray(np.where(share > 0, np.sqrt(variance * np.abs(share)) / length, np.inf))


def _predicted_gain(step: FloatArray, normal: FloatArray, slope: FloatArray) -> float:
    """Return the decrease of the misfit by a step according to the normal equations."""
    return float(step.ravel() @ (2 * slope - normal @ step.ravel()))


def _limited(step: FloatArray, parameters: FloatArray, limits: tuple[float, float]) -> FloatArray:
    """Return the step, limited for each mode to the linear range and to positive damping.

    For a mode outside the range, with poorly determined damping, the limit is a part of its distance from the
    range. Participation factors, with a largest value of 1, change by no more than `largest_step`.
    """
    stiffness, damping = parameters[:, :2].T
    outside = np.abs(stiffness - np.clip(stiffness, *limits))
    largest_change = MODAL_FIT.largest_step * np.minimum(np.maximum(np.abs(damping), outside), stiffness)
    longest = np.maximum(np.abs(step[:, :2]).max(axis=1), SAFE_DIVISOR)
    parameter_weights = np.maximum(np.abs(step[:, 2:]).max(axis=1, initial=0.0), SAFE_DIVISOR)
    return np.asarray(
        step
        * np.minimum(1.0, np.minimum(largest_change / longest, MODAL_FIT.largest_step / parameter_weights))[
            :, None
        ]
    )

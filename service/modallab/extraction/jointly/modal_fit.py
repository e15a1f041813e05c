"""All modes in all FRFs at once, by weighted least squares, with their covariance."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.progress import Progress, silent
from modallab.extraction.jointly.modal_basis import BASES, ModalBasis
from modallab.extraction.jointly.modal_covariance import Uncertainty, turned, uncertainty
from modallab.extraction.jointly.projection import Linear, Scaled, scaled, solve_linear
from modallab.extraction.options import Damping

ROUNDS = 40  # steps tried; from a pole finder's start four to eight are taken
SETTLED = 0.02  # standard errors: what a last step may still move a mode by
NOTHING = 0.05  # of what random error lowers the misfit by per unknown: a step that wins less is the last
LEVEL = 1e-9  # of the misfit: what a step gains or loses by rounding, and through directions nobody sees
EXACT = 1e-13  # of an eigenvalue, where the lines hold rounding only
FARTHEST = 0.5  # of a mode's own damping: what one step may change of it, or the slopes no longer hold
# Of the ends of the range: a mode further below is but a mass, further above but a constant and the pole held
# there. It would wander for ever.
FARTHEST_BELOW, FARTHEST_ABOVE = 0.3, 1.4
FIRST, STRICTER, LOOSER = 1e-4, 10.0, 0.1  # Levenberg-Marquardt damping, of the normal matrix's diagonal


@dataclass(frozen=True, eq=False)
class ModalFit:
    """Receptance `H_j = sum_r A_rj/(lambda_r - omega^2) + R_j - L_j/omega^2` fitted to every FRF.

    Standard errors are those of the linearised fit, widened by the misfit where that exceeds 1; of a
    complex number: of either of its parts.
    """

    eigenvalue: ComplexArray  # (n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2, rising
    modal_constant: ComplexArray  # (n_modes, n_frf) 1/kg
    residuals: ComplexArray  # (2, n_frf) L below the range, 1/kg, and R above it, m/N
    eigenvalue_covariance: FloatArray  # (2 n_modes, 2 n_modes) of all frequencies, Hz, then all loss factors
    modal_constant_error: FloatArray  # (n_modes, n_frf) 1/kg
    misfit: FloatArray  # (n_frf,) mean square residual over the lines' variance
    # share of the least random error at each line that all FRFs have in common, from 0 to 1
    common: float = 0.0

    def __post_init__(self) -> None:
        n, shape = len(self.eigenvalue), self.modal_constant.shape
        covariance = frozen(self.eigenvalue_covariance, float, (2 * n, 2 * n), name="eigenvalue_covariance")
        object.__setattr__(self, "eigenvalue_covariance", covariance)
        for name, of, size in (
            ("eigenvalue", complex, (n,)),
            ("modal_constant", complex, (n, None)),
            ("residuals", complex, (2, shape[1])),
            ("modal_constant_error", float, shape),
            ("misfit", float, shape[1:]),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), of, size, name=name))

    @property
    def frequency(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.asarray(np.sqrt(self.eigenvalue.real) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(n_modes,)."""
        return np.asarray(self.eigenvalue.imag / self.eigenvalue.real)

    @property
    def frequency_error(self) -> FloatArray:
        """(n_modes,) Hz."""
        return self._errors[: len(self.eigenvalue)]

    @property
    def loss_factor_error(self) -> FloatArray:
        """(n_modes,)."""
        return self._errors[len(self.eigenvalue) :]

    @property
    def _errors(self) -> FloatArray:
        return np.asarray(np.sqrt(np.maximum(np.diag(self.eigenvalue_covariance), 0.0)))


def fit_modes(
    freq: FloatArray,
    receptance: ComplexArray,
    weight: FloatArray,
    start: ComplexArray,
    *,
    damping: Damping = Damping.STRUCTURAL,
    progress: Progress = silent,
) -> ModalFit:
    """Return all modes in all FRFs, with residuals, from eigenvalues to start at.

    Separable least squares: modal constants and residuals are solved for inside (with `start` held they
    are the least-squares frequency-domain shapes), Gauss-Newton steps on the eigenvalues alone, damped
    as by Levenberg and Marquardt. Slopes by Kaufman's form of the variable projection.

    Parameters
    ----------
    freq
        (n_lines,) Hz, above 0, in any spacing.
    receptance
        (n_lines, n_frf) m/N.
    weight
        (n_lines, n_frf) one over E|error|^2; 0 leaves a line out.
    start
        (n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2.
    damping
        Law of the modes.
    progress
        Told how many steps have been taken.

    References
    ----------
    Golub, G. H. and Pereyra, V. (1973), SIAM Journal on Numerical Analysis 10, 413-432.
    Kaufman, L. (1975), BIT 15, 49-57.
    """
    basis = BASES[damping]
    lines = scaled(2 * np.pi * freq, receptance, weight)
    begin = basis.parameters(np.sort_complex(start) / lines.unit**2)
    parameters, linear = _descend(lines, basis, begin, progress)
    order = np.argsort(parameters[:, 0], kind="stable")
    if (np.diff(order) < 0).any():  # modes have changed places
        parameters = parameters[order]
        linear = solve_linear(lines, basis, parameters)
    return _concluded(lines, basis, parameters, linear, uncertainty(lines, basis, parameters, linear))


def held_modes(
    freq: FloatArray,
    receptance: ComplexArray,
    weight: FloatArray,
    eigenvalue: ComplexArray,
    *,
    damping: Damping = Damping.STRUCTURAL,
) -> ModalFit:
    """Return modal constants and residuals with the eigenvalues held; parameters as `fit_modes`.

    Least squares in the frequency domain: the shapes of known poles. The covariance of the eigenvalues is
    that which they would have if they too were fitted, from here.
    """
    basis = BASES[damping]
    lines = scaled(2 * np.pi * freq, receptance, weight)
    parameters = basis.parameters(np.sort_complex(eigenvalue) / lines.unit**2)
    linear = solve_linear(lines, basis, parameters)
    return _concluded(lines, basis, parameters, linear, uncertainty(lines, basis, parameters, linear))


def fitted_receptance(fit: ModalFit, freq: FloatArray, damping: Damping) -> ComplexArray:
    """Return the receptance that a fit gives back, (n_lines, n_frf) m/N, residuals included.

    Parameters
    ----------
    freq
        (n_lines,) Hz, above 0.
    damping
        Law it was fitted with.
    """
    basis = BASES[damping]
    omega = 2 * np.pi * freq
    parameters = basis.parameters(fit.eigenvalue)
    parts = np.stack([fit.modal_constant.real, fit.modal_constant.imag], axis=2)
    coefficients = np.linalg.inv(basis.constant(parameters))[:, None] @ parts[..., None]
    columns = basis.columns(omega, parameters).reshape(len(freq), -1)
    modes = columns @ coefficients[..., 0].swapaxes(1, 2).reshape(-1, fit.modal_constant.shape[1])
    below, above = fit.residuals
    return np.asarray(modes + above - below / omega[:, None] ** 2, complex)


def _descend(
    lines: Scaled, basis: ModalBasis, parameters: FloatArray, progress: Progress
) -> tuple[FloatArray, Linear]:
    """Return the parameters of least misfit, and what is linear there."""
    linear = solve_linear(lines, basis, parameters)
    damping, ends = FIRST, (float(lines.omega.min()) ** 2, 1.0)
    n_spare = max(2 * int((lines.weight > 0).sum()) - linear.coefficients.size - parameters.size, 1)
    # modes that begin beyond the range stay there: what they are for is not in it
    lowest = np.where(parameters[:, 0] > ends[1], ends[1], FARTHEST_BELOW**2 * ends[0])
    highest = np.where(parameters[:, 0] < ends[0], ends[0], FARTHEST_ABOVE**2 * ends[1])
    for n in range(ROUNDS):
        progress(n / ROUNDS, "fitting all modes to all FRFs")
        normal, slope = _normal_equations(basis, linear)
        step = _limited(_step(normal, slope, damping).reshape(parameters.shape), parameters, ends)
        trial = parameters + step
        trial[:, 0] = np.clip(trial[:, 0], lowest, highest)
        if not _moves(trial - parameters, normal, parameters, 2 * linear.misfit.sum() / n_spare):
            break
        tried = solve_linear(lines, basis, trial)
        gain = float(linear.misfit.sum() - tried.misfit.sum())
        if abs(gain) < LEVEL * linear.misfit.sum():
            break
        if gain > 0:
            parameters, linear, damping = trial, tried, damping * LOOSER
            if gain < NOTHING * linear.misfit.sum() / n_spare:
                break
        else:
            damping = max(damping, FIRST) * STRICTER
            if damping > 1 / FIRST**2:  # rounding: no smaller step does better
                break
    return parameters, linear


def _normal_equations(basis: ModalBasis, linear: Linear) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix of all parameters (2 n_modes, 2 n_modes) and its right-hand side."""
    c = turned(basis, linear)
    normal = np.einsum("jps,jsq->pq", c @ linear.beside, c.swapaxes(1, 2), optimize=True)
    return normal, np.einsum("jps,js->p", c, linear.gradient)


def _step(normal: FloatArray, slope: FloatArray, damping: float) -> FloatArray:
    length = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    even = normal / np.outer(length, length) + (damping + 1e-14) * np.eye(len(length))
    return np.asarray(np.linalg.solve(even, slope / length) / length)


def _moves(step: FloatArray, normal: FloatArray, parameters: FloatArray, variance: float) -> bool:
    """Return whether a step is more than a small part of the standard errors, and than rounding."""
    far = float(step.ravel() @ normal @ step.ravel()) > SETTLED**2 * variance
    return far and bool((np.abs(step) > EXACT * parameters[:, :1]).any())


def _limited(step: FloatArray, parameters: FloatArray, ends: tuple[float, float]) -> FloatArray:
    """Return the step, each mode's cut to where its slopes still hold and its damping stays positive.

    Of a mode beyond the ends of the range, whose damping hardly shows, to part of its distance from them.
    """
    stiffness, damping = parameters.T
    beyond = np.abs(stiffness - np.clip(stiffness, *ends))
    most = FARTHEST * np.minimum(np.maximum(np.abs(damping), beyond), stiffness)
    longest = np.maximum(np.abs(step).max(axis=1), 1e-300)
    return np.asarray(step * np.minimum(1.0, most / longest)[:, None])


def _concluded(
    lines: Scaled, basis: ModalBasis, parameters: FloatArray, linear: Linear, known: Uncertainty
) -> ModalFit:
    """Return the fit in physical units."""
    loss_factor, slope = basis.loss_factor(parameters)
    frequency = lines.unit * np.sqrt(parameters[:, 0]) / (2 * np.pi)
    n = len(parameters)
    slopes = np.zeros((2 * n, n, 2))
    modes = np.arange(n)
    slopes[modes, modes, 0] = frequency / (2 * parameters[:, 0])
    slopes[n + modes, modes] = slope
    by = slopes.reshape(2 * n, 2 * n)
    per_coefficient = basis.constant(parameters)
    coefficients = linear.coefficients[:, : 2 * n].reshape(-1, n, 2)
    parts = np.einsum("rck,jrk->rjc", per_coefficient, coefficients)
    variance = np.einsum("rck,jrkl,rcl->rj", per_coefficient, known.coefficients, per_coefficient) / 2
    scale = lines.unit**2 * lines.size
    residuals = linear.coefficients[:, 2 * n :]
    above, below = residuals[:, 0] + 1j * residuals[:, 1], residuals[:, 2] + 1j * residuals[:, 3]
    return ModalFit(
        eigenvalue=(2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor),
        modal_constant=(parts[..., 0] + 1j * parts[..., 1]) * scale,
        residuals=np.stack([below * scale, above * lines.size]),
        eigenvalue_covariance=by @ known.parameters @ by.T,
        modal_constant_error=np.sqrt(np.maximum(variance, 0.0)) * scale,
        misfit=known.misfit,
        common=known.common,
    )

"""Fits of an unknown cause at one place: a free complex number at every line, beside nuisance parameters."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.normalised_difference import logarithm_weight, normalised_difference
from modallab.diagnosis.unknown.settings import UNKNOWN
from modallab.estimation.force_noise import decorrelated_by_run


@dataclass(frozen=True, eq=False)
class Influence:
    """Ratio of the FRFs with a cause of one complex number z a line to those without it.

    1 - coupling z / (1 + own z): exact for a dynamic stiffness z, N/m, between one motion and the ground;
    with `own` 0 also for a change z of a channel's gain.
    """

    coupling: ComplexArray
    """(n_freq, n_frf), 1/unit of z: alpha_ox alpha_xd / alpha_od of a stiffness at x."""
    own: ComplexArray
    """(n_freq, n_frf), 1/unit of z: alpha_xx of a stiffness at x."""

    def ratio(self, z: ComplexArray) -> ComplexArray:
        """Return the ratio (n_freq, n_frf) at z (n_freq,)."""
        return 1 - self.coupling * z[:, None] / (1 + self.own * z[:, None])

    def derivative(self, z: ComplexArray) -> ComplexArray:
        """Return the derivative (n_freq, n_frf) of the ratio by z (n_freq,)."""
        return -self.coupling / (1 + self.own * z[:, None]) ** 2

    def logarithmic_derivative(self, z: ComplexArray) -> ComplexArray:
        """Return the derivative (n_freq, n_frf) of the logarithm of the ratio by z (n_freq,).

        It stays finite where a large z stops a motion and the ratio is 0.
        """
        without_coupling = 1 + (self.own - self.coupling) * z[:, None]
        return -self.coupling / ((1 + self.own * z[:, None]) * without_coupling)


@dataclass(frozen=True, eq=False)
class LineFit:
    """Best value of z at every line, with the nuisance parameters that fit best beside it."""

    z: ComplexArray
    """(n_freq,) in the unit of the influence."""
    error: FloatArray
    """(n_freq,) standard error of real and of imaginary part; inf where no FRF tells z."""
    step: FloatArray
    """(n,) of the nuisance parameters from the position of the prediction, standard deviations."""
    misfit: float
    """Sum of squares of the whitened residuals."""
    chi_square: float
    """The same with the squares of the prior."""


class LineByLine:
    """Whitened residuals of fitted FRFs, and fits of a free number at every line.

    Parameters
    ----------
    prediction
        Spectra without the unknown cause, and derivatives by the nuisance parameters.
    """

    def __init__(self, prediction: CoarsePrediction) -> None:
        observed = self._observed = prediction.observed
        self._h = prediction.predict(prediction.base).h
        self.mask = observed.fitted
        self._weight = logarithm_weight(observed.error)
        nuisances = prediction.nuisances
        n_fitted = int(self.mask.sum())
        self.nuisances = nuisances
        self.slopes = np.zeros((*self.mask.shape, len(nuisances)), complex)
        if len(nuisances):
            real, imaginary = nuisances.derivatives[:n_fitted], nuisances.derivatives[n_fitted : 2 * n_fitted]
            self.slopes[self.mask] = real + 1j * imaginary

    @property
    def n_freedom(self) -> int:
        """Degrees of freedom of a fit line by line: real residuals less free numbers."""
        told = self.mask.sum(axis=1)
        return int(2 * np.maximum(told - 1, 0).sum())

    @property
    def n_data(self) -> int:
        """Number of real residuals."""
        return 2 * int(self.mask.sum())

    def fit(
        self,
        influence: Influence,
        fixed_step: FloatArray | None = None,
        *,
        max_steps: int = UNKNOWN.max_steps,
    ) -> LineFit:
        """Return the best z at every line: Gauss-Newton with z eliminated line by line.

        Parameters
        ----------
        fixed_step
            (n,) step of the nuisance parameters that is kept; None: they are fitted too.
        max_steps
            Steps at most.
        """
        z, last = self._start(influence), np.inf
        step = np.zeros(len(self.nuisances)) if fixed_step is None else fixed_step
        for _ in range(max_steps):
            residual = self.residual(influence, z) + self.slopes @ step
            slope = self.slope_of(influence, z)
            size = (np.abs(slope) ** 2).sum(axis=1) + SAFE_SQUARED_DIVISOR
            if fixed_step is None:
                change = self._step_beside(slope, size, residual, step)
                step, residual = step + change, residual + self.slopes @ change
            target = -(slope.conj() * residual).sum(axis=1) / size
            z, squares = self._line_search(influence, z, target, step)
            total = float(squares.sum()) + self._prior(step)
            if last - total < UNKNOWN.tolerance * max(1.0, total / max(self.n_freedom, 1)):
                break
            last = total
        size = (np.abs(self.slope_of(influence, z)) ** 2).sum(axis=1)
        with np.errstate(divide="ignore"):
            error = 1 / np.sqrt(size)
        return LineFit(z, error, step, float(squares.sum()), total)

    def best_square(self, influence: Influence, z: ComplexArray) -> float:
        """Return the sum of squares at z (n_freq,), the prior included, with the best nuisance parameters."""
        residual, step = self.residual(influence, z), np.zeros(len(self.nuisances))
        step = self._nuisance_step(self._curvature, residual, step)
        return float((np.abs(residual + self.slopes @ step) ** 2).sum()) + self._prior(step)

    @cached_property
    def _curvature(self) -> FloatArray:
        """(n, n): half the second derivatives of the sum of squares by the nuisance parameters."""
        matrix = self.slopes[self.mask]
        return np.asarray((matrix.conj().T @ matrix).real)

    def _step_beside(
        self, slope: ComplexArray, size: FloatArray, residual: ComplexArray, position: FloatArray
    ) -> FloatArray:
        """Return the step (n,) of the nuisance parameters where z follows it at every line.

        Parameters
        ----------
        slope
            (n_freq, n_frf), of the residuals by z.
        size
            (n_freq,), sums of its squares.
        """
        share = (slope.conj()[:, None, :] @ self.slopes)[:, 0]
        curvature = self._curvature - ((share / size[:, None]).conj().T @ share).real
        remainder = residual - slope * ((slope.conj() * residual).sum(axis=1) / size)[:, None]
        return self._nuisance_step(curvature, remainder, position)

    def _start(self, influence: Influence) -> ComplexArray:
        """Return the best z (n_freq,) by linear least squares, `own` averaged over the FRFs."""
        observed, mask = self._observed, self.mask
        weight = np.where(mask, 1 / (observed.error * np.abs(observed.h)), 0.0)
        slope, difference = weight * self._h * influence.coupling, weight * (observed.h - self._h)
        size = (np.abs(slope) ** 2).sum(axis=1)
        linear = -(slope.conj() * difference).sum(axis=1) / (size + SAFE_SQUARED_DIVISOR)
        own = (np.abs(slope) ** 2 * influence.own).sum(axis=1) / (size + SAFE_SQUARED_DIVISOR)
        with np.errstate(divide="ignore", invalid="ignore"):
            z: ComplexArray = linear / (1 - own * linear)
        without, start = ((np.abs(self.residual(influence, each)) ** 2).sum(axis=1) for each in (0 * z, z))
        return np.where(np.isfinite(start) & (start < without), z, 0.0)

    def _line_search(
        self, influence: Influence, z: ComplexArray, change: ComplexArray, step: FloatArray
    ) -> tuple[ComplexArray, FloatArray]:
        """Return z and the sums of squares (n_freq,) after the best share of a change at every line."""
        beside = self.slopes @ step
        trials = [z + share * change for share in UNKNOWN.step_shares]
        squares = np.array(
            [(np.abs(self.residual(influence, each) + beside) ** 2).sum(axis=1) for each in trials]
        )
        squares = np.where(np.isfinite(squares), squares, np.inf)
        best, lines = squares.argmin(axis=0), np.arange(len(z))
        return np.array(trials)[best, lines], squares[best, lines]

    def residual(self, influence: Influence, z: ComplexArray) -> ComplexArray:
        """Return the whitened residuals (n_freq, n_frf), real and imaginary part of unit variance each."""
        with np.errstate(divide="ignore", invalid="ignore"):  # where 1 + own z is zero
            return self._whitened(normalised_difference(self._observed, self._h * influence.ratio(z)))

    def slope_of(self, influence: Influence, z: ComplexArray) -> ComplexArray:
        """Return the derivative (n_freq, n_frf) of the whitened residuals by z."""
        inverse = self._h / np.where(self._observed.usable, self._observed.h, 1.0)
        of_logarithm = self._weight * influence.logarithmic_derivative(z)
        of_difference = (1 - self._weight) * inverse * influence.derivative(z)
        return self._whitened(-of_logarithm - of_difference)

    def _whitened(self, difference: ComplexArray) -> ComplexArray:
        observed = self._observed
        frf = np.where(self.mask, difference / observed.error, 0.0)
        if observed.shared_noise is not None:
            frf = decorrelated_by_run(frf, observed.shared_noise, self.mask, observed.forces)
        return np.asarray(np.where(self.mask, frf, 0.0))

    def _nuisance_step(
        self, curvature: FloatArray, residual: ComplexArray, position: FloatArray
    ) -> FloatArray:
        """Return the step (n,) of the nuisance parameters that reduces the residuals and the prior.

        Parameters
        ----------
        curvature
            (n, n), of the residuals.
        """
        nuisances = self.nuisances
        if not len(nuisances):
            return np.zeros(0)
        now = nuisances.position + position
        gradient = np.tensordot(self.slopes.conj(), residual, axes=((0, 1), (0, 1))).real
        gradient = gradient + nuisances.precision * now
        curvature = curvature + np.diag(nuisances.precision)
        size = np.sqrt(np.diag(curvature))
        root = scipy.linalg.cholesky(curvature / np.outer(size, size))
        target = scipy.linalg.solve_triangular(root, -gradient / size, trans=1)
        low, high = (nuisances.low - now) * size, (nuisances.high - now) * size
        free = scipy.linalg.solve_triangular(root, target)
        if ((free >= low) & (free <= high)).all():
            return np.asarray(free / size)
        return np.asarray(scipy.optimize.lsq_linear(root, target, (low, high), method="bvls").x / size)

    def _prior(self, step: FloatArray) -> float:
        return float(self.nuisances.precision @ (self.nuisances.position + step) ** 2)

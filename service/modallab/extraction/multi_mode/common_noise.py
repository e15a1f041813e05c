"""Random errors that all FRFs of a fit have in common."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_settings import MODAL_COVARIANCE
from modallab.extraction.multi_mode.pole_basis import PoleBasis, all_columns
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
    columns_and_slopes,
    line_blocks,
    stack_references,
)
from modallab.extraction.preprocessing.correlated_lines import CorrelatedLines


@dataclass(frozen=True, eq=False)
class CommonNoise:
    """Relative error of lines that is the same in all FRFs of a reference."""

    variance: FloatArray
    """(n_lines, n_references) E|error|^2 over the squared FRF."""
    part: float
    """1, part of the variance that the errors of the lines might have in common."""
    share: float
    """1, part of the variance of the lines that show it."""


def common_noise(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, linear: LinearSolution
) -> CommonNoise | None:
    """Return the errors common to all FRFs; None if their residuals are not correlated.

    Least squares over all pairs of FRFs at all lines: standardised residuals of two FRFs with relative
    variances v_i and v_j, and a common part k v_c, have the correlation `k v_c/sqrt(v_i v_j)`. The
    common variance v_c is that by noise of the force, as coherence shows it, or the least at the line:
    whichever explains more of the correlations.

    Parameters
    ----------
    lines, basis, parameters, linear
        As in the fit.
    """
    if lines.response.shape[1] == lines.n_references:
        return None  # one DoF has no second FRF of the same reference
    least, by_force = _Pattern.empty(), _Pattern.empty()
    of_frf = lines.reference_mixing(basis, parameters).coefficients(linear.coefficients).T
    force_variance = lines.noise.force_variance if lines.n_references == 1 else None
    for block in line_blocks(len(lines.omega), 8 * lines.response.shape[1]):
        frf_response = all_columns(basis, lines.omega[block], parameters, lines.fixed_poles) @ of_frf
        # with several references, errors are common to the FRFs of one reference
        fitted, response, weight = (
            stack_references(values, lines.n_references)
            for values in (frf_response, lines.response[block], lines.weight[block])
        )
        exact = weight * np.abs(fitted) ** 2  # one over the relative variance
        # errors are proportional to the response, so that its phase is removed
        turn = np.sqrt(weight) * fitted.conj() / np.maximum(np.abs(fitted), SAFE_DIVISOR)
        score = turn * (response - fitted)
        variance = 1 / np.maximum(exact.max(axis=1), SAFE_DIVISOR) * (exact.max(axis=1) > 0)
        least = least.with_lines(score, exact, variance)
        if force_variance is not None:
            by_force = by_force.with_lines(score, exact, force_variance[block])
    inflation = 1.0 if lines.noise.correlated is None else lines.noise.correlated.squared_correlation
    if by_force.gain < least.gain:
        return least.noise(lines.n_references, inflation)
    noise = by_force.noise(lines.n_references, inflation)
    if noise is None:
        return None
    part = noise.part if noise.part < MODAL_COVARIANCE.simultaneous_part else 1.0  # one force for all
    return CommonNoise(noise.variance * (part / noise.part), part, part * by_force.share)


@dataclass(frozen=True, eq=False)
class _Pattern:
    """Sums over lines of the correlations of FRFs, for a common variance of unknown scale."""

    variance: FloatArray
    """(n_lines n_references,) common relative variance."""
    cross_power: float = 0.0
    power: float = 0.0
    expected: float = 0.0
    expected_power: float = 0.0
    squares: float = 0.0

    @classmethod
    def empty(cls) -> "_Pattern":
        return cls(np.zeros(0))

    def with_lines(self, score: ComplexArray, exact: FloatArray, variance: FloatArray) -> "_Pattern":
        """Return the sums with further lines.

        Parameters
        ----------
        score
            (n, n_frf) standardised residuals.
        exact
            (n, n_frf) one over the relative variance of the lines.
        variance
            (n,) common relative variance.
        """
        near2 = exact * variance[:, None]
        near = np.sqrt(near2) * score
        size = np.abs(near) ** 2
        return _Pattern(
            np.concatenate([self.variance, variance]),
            self.cross_power + float((np.abs(near.sum(axis=1)) ** 2 - size.sum(axis=1)).sum()),
            self.power + float(size.sum()),
            self.expected + float((near2.sum(axis=1) ** 2 - (near2**2).sum(axis=1)).sum()),
            self.expected_power + float(near2.sum()),
            self.squares + float((near2**2).sum()),
        )

    @property
    def share(self) -> float:
        """Mean part of the variance of the lines that may be common, weighted by itself."""
        return min(self.squares / self.expected_power, 1.0) if self.expected_power > 0 else 0.0

    @property
    def gain(self) -> float:
        """Decrease of the squared differences of the correlations by this pattern."""
        return max(self.cross_power, 0.0) ** 2 / self.expected if self.expected > 0 else 0.0

    def noise(self, n_references: int, inflation: float) -> CommonNoise | None:
        """Return the common errors; None where they are not significant.

        Parameters
        ----------
        inflation
            Factor of the variance of the sums by the correlation of lines.
        """
        # without common errors, the sum has a standard deviation of the root of `expected`
        spread = np.sqrt(inflation * self.expected)
        if not (self.power > 0 and self.expected > 0) or (
            self.cross_power < MODAL_COVARIANCE.common_noise_deviations * spread
        ):
            return None
        # degrees of freedom used by the fit, and a misfit above 1, affect both sums alike
        part = float(np.clip(self.cross_power / self.expected * self.expected_power / self.power, 0.0, 1.0))
        return CommonNoise(part * self.variance.reshape(-1, n_references), part, part)


def common_noise_covariance(
    lines: ScaledLines,
    basis: PoleBasis,
    parameters: FloatArray,
    linear: LinearSolution,
    influence: FloatArray,
    wide: FloatArray,
    noise: CommonNoise,
) -> FloatArray:
    """Return the contribution of common errors to the covariance of the gradient, (n, n).

    Parameters
    ----------
    lines, basis, parameters, linear
        As in the fit.
    influence
        (n_dof, n_columns + n_slopes, n) influence of the sums over lines on the gradient.
    wide
        (n_dof,) factor of the variance by the misfit.
    noise
        From `common_noise`.
    """
    n_parameters = influence.shape[2]
    mix = lines.reference_mixing(basis, parameters)
    of_frf = mix.coefficients(linear.coefficients).T
    by_reference = mix.influence(influence)
    total = np.zeros((n_parameters, n_parameters))
    correlated = lines.noise.correlated
    width = 2 * MODAL_COVARIANCE.frfs_in_memory * n_parameters
    for block in line_blocks(len(lines.omega), width) if correlated is None else [slice(None)]:
        basis_columns = columns_and_slopes(lines, basis, parameters, block)
        fitted = basis_columns[:, : mix.n_frf_columns] @ of_frf
        for k, reference_influence in enumerate(by_reference):
            frfs = slice(k, None, lines.n_references)
            deviation = np.sqrt(0.5 * noise.variance[block, k])[:, None] * np.sqrt(wide)
            pull = lines.weight[block, frfs] * fitted[:, frfs] * deviation
            total += _reference_covariance(basis_columns, reference_influence, pull, correlated)
    return total


def _reference_covariance(
    basis_columns: ComplexArray,
    influence: FloatArray,
    pull: ComplexArray,
    correlated: CorrelatedLines | None,
) -> FloatArray:
    """Return that contribution of one reference at a block of lines, of all lines if they are correlated.

    Parameters
    ----------
    pull
        (n_lines, n_dof) weighted common errors of the FRFs.
    """
    n = influence.shape[2]
    sum_over = np.zeros((len(basis_columns), n), complex)
    total = np.zeros((n, n))
    together = MODAL_COVARIANCE.frfs_in_memory if correlated is None else 1
    for start in range(0, len(influence), together):
        block = slice(start, start + together)
        frf_influence = _influence(basis_columns, influence[block]).conj() * pull[:, block, None]
        sum_over += frf_influence.sum(axis=1)
        total -= _real_square(frf_influence.reshape(-1, n), correlated)
    return np.asarray(total + _real_square(sum_over, correlated))


def _influence(basis_columns: ComplexArray, influence: FloatArray) -> ComplexArray:
    """Return the influence of each line on the gradient, (n_lines, n_frf, n), from that of its columns."""
    flat = influence.swapaxes(0, 1).reshape(influence.shape[1], -1)
    out = basis_columns.real.copy() @ flat + 1j * (basis_columns.imag.copy() @ flat)
    return np.asarray(out.reshape(len(basis_columns), len(influence), -1))


def _real_square(values: ComplexArray, correlated: CorrelatedLines | None) -> FloatArray:
    """Return the real part of the products of columns (n_lines, n), summed over errors of lines, (n, n)."""
    if correlated is not None:
        values = correlated.independent(np.asarray(values.conj().T)).T
    return np.asarray(values.real.T @ values.real + values.imag.T @ values.imag)

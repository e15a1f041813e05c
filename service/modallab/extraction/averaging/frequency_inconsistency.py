"""Inconsistency of natural frequencies between FRFs, and its cause."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.averaging.means import chi_squares, is_significant
from modallab.extraction.averaging.settings import INCONSISTENCY


@dataclass(frozen=True, eq=False)
class FittedModes:
    """Fits of each mode in each FRF; every array (n_modes, n_frf)."""

    frequency: FloatArray
    """Hz."""
    frequency_error: FloatArray
    """Hz, standard error."""
    loss_factor: FloatArray
    """Structural loss factor."""
    good: BoolArray
    """True for accepted fits."""
    shape: ComplexArray
    """1/sqrt(kg) if `scaled`."""
    shape_error: FloatArray
    """Standard error of the modulus."""
    scaled: bool
    """True if shapes are mass-normalised."""

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the unweighted mean of the accepted fits, (n_modes, 1)."""
        count = np.maximum(self.good.sum(axis=1, keepdims=True), 1)
        return np.asarray(np.where(self.good, values, 0.0).sum(axis=1, keepdims=True) / count)

    @property
    def shift(self) -> FloatArray:
        """Relative change of the eigenvalue from that of the mean frequency; 0 for rejected fits."""
        mean = self.mean(self.frequency)
        return np.where(self.good, (self.frequency / np.where(mean > 0, mean, 1.0)) ** 2 - 1, 0.0)

    @property
    def shift_error(self) -> FloatArray:
        """Standard error of `shift`, including the error that fits neglect."""
        mean = self.mean(self.frequency)
        error = np.hypot(
            self.frequency_error, INCONSISTENCY.neglected_error * self.mean(self.loss_factor) * mean
        )
        return np.asarray(2 * error / np.where(mean > 0, mean, 1.0))


@dataclass(frozen=True, eq=False)
class _EigenvalueRegression:
    """Regression of relative eigenvalues, `level - slope regressor`, for each mode and for all together."""

    mode_slope: FloatArray
    """(n_modes,) NaN where a mode does not determine it."""
    mode_error: FloatArray
    """(n_modes,) standard error."""
    slope: float
    """Slope common to all modes."""
    error: float
    """Standard error of the common slope."""
    mode_level: FloatArray
    """(n_modes,) levels with separate slopes."""
    level: FloatArray
    """(n_modes,) levels with the common slope."""
    mode_remainder: FloatArray
    """(n_modes,) chi-square that separate slopes leave."""
    remainder: float
    """Chi-square that the common slope leaves."""
    total: float
    """Chi-square without regression."""


def find_frequency_inconsistency(modes: FittedModes) -> FrequencyInconsistency | None:
    """Return the inconsistency of frequencies, None where random error explains their differences.

    A mass m that moves with the response makes the eigenvalue at position j `lambda_j = lambda (1 - m
    phi_j^2)` to first order in m, with the mass-normalised shape phi at the position. A structure that
    changes steadily during the test has `lambda_j = lambda (1 + 2 d t_j)` in all modes, with t from 0 at the
    first FRF to 1 at the last. Each law is fitted to the relative shifts of all modes by weighted least
    squares. It is identified as the cause if it is significant by five standard errors, including the misfit,
    and explains at least half of the chi-square.
    """
    degrees = np.maximum(modes.good.sum(axis=1) - 1, 0)
    total, trimmed = chi_squares(modes.shift, _weight(modes, modes.shift_error))
    if not is_significant(float(total.sum()), int(degrees.sum())):
        return None
    cause, law, explained = _identified_cause(modes, total, int(degrees.sum()))
    # a single outlying FRF is no inconsistency: the others must differ without the furthest of each mode
    if law is None and not is_significant(float(trimmed.sum()), int(np.maximum(degrees - 1, 0).sum())):
        return None
    size, mode_size = _sizes(cause, law, modes)
    mean = modes.mean(modes.frequency)
    return FrequencyInconsistency(
        cause=cause,
        shift=np.where(modes.good, modes.frequency - mean, np.nan),
        shift_error=np.where(modes.good, modes.frequency_error, np.nan),
        chi_square=total,
        degrees=degrees,
        explained=explained,
        size=size[0],
        size_error=size[1],
        mode_size=mode_size[0],
        mode_size_error=mode_size[1],
        still_frequency=mean[:, 0] * np.sqrt(np.maximum(_level(cause, law, len(total)), 0.0)),
    )


def _weight(modes: FittedModes, error: FloatArray) -> FloatArray:
    usable = modes.good & (error > 0)
    return np.where(usable, 1 / np.where(usable, error, 1.0) ** 2, 0.0)


def _centred(values: FloatArray, weight: FloatArray) -> FloatArray:
    total = weight.sum(axis=1, keepdims=True)
    share = weight / np.where(total > 0, total, 1.0)
    return np.asarray(values - (share * values).sum(axis=1, keepdims=True))


def _identified_cause(
    modes: FittedModes, total: FloatArray, degrees: int
) -> tuple[InconsistencyCause, _EigenvalueRegression | None, float]:
    """Return the cause, its regression and the part of the chi-square it explains; UNKNOWN if none does."""
    position = np.linspace(0.0, 1.0, modes.good.shape[1])[None].repeat(len(total), axis=0)
    squared = (modes.shape**2).real
    mass = _fit_law(modes, squared, modes.shift_error)
    # errors of the regressor are converted to the shifts that they would cause
    total_error = np.hypot(modes.shift_error, 2 * mass.slope * np.abs(modes.shape) * modes.shape_error)
    mass = _fit_law(modes, squared, total_error)
    candidates: list[tuple[float, InconsistencyCause, _EigenvalueRegression]] = []
    for cause, law in (
        (InconsistencyCause.ROVING_MASS if modes.scaled else InconsistencyCause.SQUARED_SHAPE, mass),
        (InconsistencyCause.STEADY_DRIFT, _fit_law(modes, position, modes.shift_error)),
    ):
        separate_slopes = cause is InconsistencyCause.SQUARED_SHAPE  # without scale, slopes of modes differ
        remainder = float(law.mode_remainder.sum()) if separate_slopes else law.remainder
        spare = degrees - (len(total) if separate_slopes else 1)
        gain, explained = law.total - remainder, 1 - remainder / max(law.total, SAFE_DIVISOR)
        if (
            spare > 0
            and explained >= INCONSISTENCY.explained_fraction
            and gain > INCONSISTENCY.cause_errors**2 * max(remainder / spare, 1.0)
        ):
            candidates.append((explained, cause, law))
    if not candidates:
        return InconsistencyCause.UNKNOWN, None, 0.0
    explained, cause, law = max(candidates, key=lambda entry: entry[0])
    return cause, law, explained


def _fit_law(modes: FittedModes, regressor: FloatArray, error: FloatArray) -> _EigenvalueRegression:
    weight = _weight(modes, error)
    x, y = _centred(regressor, weight), _centred(modes.shift, weight)
    xx, xy, yy = (np.asarray((weight * product).sum(axis=1)) for product in (x * x, x * y, y * y))
    determined = xx > 0
    mode_slope = np.where(determined, -xy / np.where(determined, xx, 1.0), 0.0)
    mode_remainder = np.maximum(yy - mode_slope**2 * xx, 0.0)
    common = float(-xy.sum() / xx.sum()) if determined.any() else 0.0
    remainder = float((yy + 2 * common * xy + common**2 * xx).sum())
    spare = np.maximum(modes.good.sum(axis=1) - 2, 1)
    mode_error = np.sqrt(np.maximum(mode_remainder / spare, 1) / np.where(determined, xx, 1.0))
    scatter = max(remainder / max(int((modes.good.sum(axis=1) - 1).sum()) - 1, 1), 1.0)
    return _EigenvalueRegression(
        mode_slope=np.where(determined, mode_slope, np.nan),
        mode_error=np.where(determined, mode_error, np.nan),
        slope=common,
        error=float(np.sqrt(scatter / xx.sum())) if determined.any() else np.inf,
        mode_level=1 + _weighted(modes.shift + mode_slope[:, None] * regressor, weight),
        level=1 + _weighted(modes.shift + common * regressor, weight),
        mode_remainder=mode_remainder,
        remainder=remainder,
        total=float(yy.sum()),
    )


def _weighted(values: FloatArray, weight: FloatArray) -> FloatArray:
    total = weight.sum(axis=1)
    return np.asarray((weight * values).sum(axis=1) / np.where(total > 0, total, 1.0))


def _level(cause: InconsistencyCause, pattern: _EigenvalueRegression | None, n_modes: int) -> FloatArray:
    if pattern is None:
        return np.ones(n_modes)
    return pattern.mode_level if cause is InconsistencyCause.SQUARED_SHAPE else pattern.level


def _sizes(
    cause: InconsistencyCause, pattern: _EigenvalueRegression | None, modes: FittedModes
) -> tuple[tuple[float, float], tuple[FloatArray, FloatArray]]:
    """Return size and standard error, of all modes and of each; see `FrequencyInconsistency`."""
    unknown = np.full(len(modes.good), np.nan)
    if pattern is None or cause in (InconsistencyCause.UNKNOWN, InconsistencyCause.SQUARED_SHAPE):
        return (0.0, 0.0), (unknown, unknown)
    if cause is InconsistencyCause.STEADY_DRIFT:
        return (-pattern.slope / 2, pattern.error / 2), (-pattern.mode_slope / 2, pattern.mode_error / 2)
    # The second-order term is m phi^2 of the mass from the mode itself, and about as much from others.
    largest = np.where(modes.good, np.abs(modes.shape) ** 2, 0.0).max(axis=1, initial=0.0)
    neglected = 2 * pattern.slope**2 * largest
    determined = np.isfinite(pattern.mode_slope)
    weight = np.where(determined, 1 / np.hypot(pattern.mode_error, neglected) ** 2, 0.0)
    mode_mass = np.where(determined, pattern.mode_slope, 0.0)
    mass = float((weight * mode_mass).sum() / weight.sum())
    scatter = float((weight * (mode_mass - mass) ** 2).sum() / max(int(determined.sum()) - 1, 1))
    error = np.sqrt(max(scatter, 1.0) / weight.sum())
    systematic = float((weight * neglected).sum() / weight.sum())  # same sign in all modes
    return (mass, float(np.hypot(error, systematic))), (
        pattern.mode_slope,
        np.hypot(pattern.mode_error, neglected),
    )

"""Random errors of the lines near a mode: its leakage, and white noise for the rest of their variance."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.leaked_lines import LeakedLines, LineErrors


@dataclass(frozen=True, eq=False)
class LineAccuracy:
    """Random error of lines, from coherence."""

    variance: FloatArray
    """(..., n_lines) E|error|^2 of a line over its squared modulus; 0 where it is not determined."""
    averages: float
    """Effective number of averages."""


@dataclass(frozen=True, eq=False)
class RandomErrors:
    """Relative errors of lines, those specific to each FRF apart from those common to all FRFs."""

    specific: LineErrors
    """(..., n_lines, n_lines) errors that are independent between FRFs."""
    common_leakage: float
    """Part of the second moments of one record's leakage that is common to all FRFs."""
    common_noise: LineErrors | None
    """(n_lines, n_lines) errors by white noise common to all FRFs; None if nothing is common."""


def relative_variance(weight: FloatArray, receptance: ComplexArray) -> FloatArray:
    """Return E|error|^2 of lines over their squared modulus; 0 where weight or receptance is 0.

    Parameters
    ----------
    weight
        (...) (N/m)^2, one over E|error|^2.
    receptance
        (...) m/N.
    """
    accuracy = weight * np.abs(receptance) ** 2
    return np.asarray(np.where(accuracy > 0, 1 / np.where(accuracy > 0, accuracy, 1.0), 0.0))


def random_errors(
    leaked: LeakedLines, white_correlation: FloatArray, accuracy: LineAccuracy, common: float = 0.0
) -> RandomErrors:
    """Return the random errors of lines: leakage, and white noise for the variance in addition to it.

    Noise of the source and of the force is common to all FRFs. Its variance is at most the median over the
    FRFs: a minimum over many FRFs would be low by chance, because each is the difference of two estimates.

    Parameters
    ----------
    leaked
        Errors by leakage of the mode.
    white_correlation
        (..., n_lines, n_lines) from `white_error_correlation`.
    accuracy
        (n_frf, n_lines) total random error of the lines.
    common
        Part of the variance that is common to all FRFs, which then have the same lines.
    """
    by_leakage = leaked.errors.scaled(1 / accuracy.averages)
    leakage_variance = np.diagonal(by_leakage.covariance, axis1=-2, axis2=-1).real
    excess = np.maximum(accuracy.variance - leakage_variance, 0.0)
    if common == 0:
        return RandomErrors(by_leakage.with_noise(_covariance(excess, white_correlation)), 0.0, None)
    common_excess = common * np.median(excess, axis=0)
    specific_noise = _covariance(np.maximum(excess - common_excess, 0.0), white_correlation)
    return RandomErrors(
        by_leakage.scaled(1 - common).with_noise(specific_noise),
        common / accuracy.averages,
        LineErrors.circular(_covariance(common_excess, white_correlation)),
    )


def _covariance(variance: FloatArray, correlation: FloatArray) -> FloatArray:
    """Return the covariance of lines of these variances, (..., n_lines, n_lines)."""
    deviation = np.sqrt(variance)
    return np.asarray(deviation[..., :, None] * deviation[..., None, :] * correlation)

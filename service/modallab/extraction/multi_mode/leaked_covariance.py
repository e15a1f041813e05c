"""Covariance of modes that are fitted to leaked lines of all FRFs."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, nearest_mode
from modallab.extraction.multi_mode.leakage_settings import LEAKED_MODES
from modallab.extraction.multi_mode.modal_fit import fitted_receptance
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import SinglePole
from modallab.extraction.preprocessing.leaked_lines import (
    LeakedLines,
    LineErrors,
    leaked_lines,
    white_error_correlation,
)
from modallab.extraction.preprocessing.random_errors import (
    LineAccuracy,
    RandomErrors,
    random_errors,
    relative_variance,
)


def with_leaked_errors(
    refined: RefinedModes, band_data: BandData, leaked: LeakageCorrection, damping: Damping
) -> ModalFit:
    """Return the fit with standard errors from the correlated errors of leaked lines.

    The influence of each line is evaluated mode by mode with the other modes fixed, together with the second
    moments of the errors of lines near one resonance. The part of the errors common to all FRFs is that of
    the fit. Correlations between modes are unchanged.

    Parameters
    ----------
    refined
        Fit to corrected lines; a mode with too few lines keeps its errors.
    band_data
        Lines before correction.
    leaked
        Leakage correction.
    damping
        Damping model.
    """
    fit, n = refined.fit, len(refined.fit.eigenvalue)
    spacing = float(np.median(np.diff(band_data.freq)))
    variance = np.diag(fit.eigenvalue_covariance).copy()
    constant = fit.modal_constant_error.copy()
    fitted = fitted_receptance(fit, band_data.freq, damping)
    nearest = nearest_mode(fit.eigenvalue, band_data.freq)
    misfit_factor = max(float(np.median(fit.misfit)), 1.0)
    for m in range(n):
        index = _lines_of_mode(fit, band_data.freq, m, nearest)
        if len(index) < LEAKED_MODES.minimum_lines:
            continue
        freq, receptance = band_data.freq[index], fitted[index].T
        influence = _influence(fit, m, freq, refined.weight[index].T, receptance)
        lines = _lines_about_mode(fit, leaked, m, freq, spacing, receptance)
        variance_of_lines = relative_variance(band_data.weight[index], band_data.receptance[index]).T
        errors = random_errors(
            lines,
            white_error_correlation(leaked.leakage, freq, spacing),
            LineAccuracy(variance_of_lines, leaked.averages),
            fit.common_noise,
        )
        eigenvalue, modulus = influence.propagate(lines, errors)
        turn = np.array([-fit.loss_factor[m], 1.0]) / fit.eigenvalue[m].real
        variance[m] = misfit_factor * eigenvalue[0, 0] / (8 * np.pi**2 * fit.frequency[m]) ** 2
        variance[n + m] = misfit_factor * (turn @ eigenvalue @ turn)
        constant[m] = np.sqrt(misfit_factor * modulus)
    scale = np.sqrt(variance / np.maximum(np.diag(fit.eigenvalue_covariance), SAFE_DIVISOR))
    covariance = fit.eigenvalue_covariance * scale[:, None] * scale
    return replace(fit, eigenvalue_covariance=covariance, modal_constant_error=constant)


@dataclass(frozen=True, eq=False)
class _Influence:
    """Derivatives of a mode with respect to the relative errors of its lines, by least squares.

    The eigenvalue shifts by the sum of `eigenvalue` times the errors over lines and FRFs. A modal constant
    shifts, along its phase, by the real part of the sum of `constant` times the errors of its FRF, and of
    `slope` times the shift of the eigenvalue.
    """

    eigenvalue: ComplexArray
    """(n_frf, n_lines) (rad/s)^2."""
    constant: ComplexArray
    """(n_frf, n_lines) 1/kg, with the eigenvalue fixed."""
    slope: ComplexArray
    """(n_frf,) 1/kg over (rad/s)^2."""

    def propagate(self, lines: LeakedLines, errors: RandomErrors) -> tuple[FloatArray, FloatArray]:
        """Return the covariance of the eigenvalue, (2, 2), and the variance of each constant's modulus."""
        eigenvalue, modulus = self._by_specific_errors(errors.specific)
        if errors.common_noise is not None:
            by_leakage = self._by_common_leakage(lines)
            by_noise = self._by_common_noise(errors.common_noise)
            eigenvalue = eigenvalue + errors.common_leakage * by_leakage[0] + by_noise[0]
            modulus = modulus + errors.common_leakage * by_leakage[1] + by_noise[1]
        return eigenvalue, np.maximum(modulus, 0.0)

    def _by_specific_errors(self, errors: LineErrors) -> tuple[FloatArray, FloatArray]:
        """Return both where errors of FRFs are independent."""
        by_frf = errors.propagate(_parts(self.eigenvalue))
        eigenvalue = by_frf.sum(axis=0)
        same_frf = self.constant + self.slope[:, None] * self.eigenvalue
        turn = np.stack([self.slope.real, -self.slope.imag], axis=-1)
        other_frfs = np.einsum("jp,jpq,jq->j", turn, eigenvalue - by_frf, turn)
        return eigenvalue, errors.propagate(same_frf[:, None])[:, 0, 0] + other_frfs

    def _by_common_leakage(self, lines: LeakedLines) -> tuple[FloatArray, FloatArray]:
        """Return both where one record's source makes the errors of all FRFs."""
        form = np.einsum("jk,jkab->kab", self.eigenvalue, lines.form)
        total = np.ones((1, len(form)), complex)
        eigenvalue = LeakedLines(form, lines.moments[0]).errors.propagate(_parts(total[0]))
        forms = self.constant[..., None, None] * lines.form + self.slope[:, None, None, None] * form
        return eigenvalue, LeakedLines(forms, lines.moments).errors.propagate(total)[:, 0, 0]

    def _by_common_noise(self, errors: LineErrors) -> tuple[FloatArray, FloatArray]:
        """Return both where lines have the same relative errors in all FRFs."""
        total = self.eigenvalue.sum(axis=0)
        modulus = errors.propagate((self.constant + self.slope[:, None] * total)[:, None])
        return errors.propagate(_parts(total)), modulus[:, 0, 0]


def _parts(influence: ComplexArray) -> ComplexArray:
    """Return the influence on real and imaginary part, (..., 2, n_lines), from (..., n_lines)."""
    return np.stack([influence, -1j * influence], axis=-2)


def _influence(
    fit: ModalFit, m: int, freq: FloatArray, weight: FloatArray, receptance: ComplexArray
) -> _Influence:
    """Return the influence of the lines of mode m; `weight` and `receptance` (n_frf, n_lines)."""
    flank = 1 / (fit.eigenvalue[m] - (2 * np.pi * freq) ** 2)
    constant = fit.modal_constant[m]
    power = (weight * np.abs(flank) ** 2).sum(axis=1)
    power = np.where(power > 0, power, np.inf)
    slope = -constant[:, None] * flank**2
    along = (weight * flank.conj() * slope).sum(axis=1) / power
    slope = slope - along[:, None] * flank
    total = float((weight * np.abs(slope) ** 2).sum())
    modulus = np.abs(constant)
    turn = constant.conj() / np.where(modulus > 0, modulus, 1.0)
    return _Influence(
        weight * slope.conj() * receptance / (total or np.inf),
        turn[:, None] * weight * flank.conj() * receptance / power[:, None],
        -turn * along,
    )


def _lines_about_mode(
    fit: ModalFit,
    leaked: LeakageCorrection,
    m: int,
    freq: FloatArray,
    spacing: float,
    receptance: ComplexArray,
) -> LeakedLines:
    """Return the errors of lines by leakage of one mode, in all FRFs; `receptance` (n_frf, n_lines)."""
    x, eigenvalue, constant = (2 * np.pi * freq) ** 2, fit.eigenvalue[m : m + 1], fit.modal_constant[m]
    background = receptance - constant[:, None] / (eigenvalue - x)
    response = SinglePole.of_mode(eigenvalue, constant, x, background)
    row = leaked.drive
    if row is None:
        drive = SinglePole.of_mode(eigenvalue, np.zeros(1, complex), x, np.zeros((1, len(x)), complex))
    else:
        drive = SinglePole.of_mode(eigenvalue, constant[row : row + 1], x, background[row : row + 1])
    return leaked_lines(leaked.leakage, freq, spacing, response, drive)


def _lines_of_mode(fit: ModalFit, freq: FloatArray, m: int, nearest: IntArray) -> IntArray:
    """Return the lines near a mode that are nearest to no other mode."""
    spacing = float(np.median(np.diff(freq)))
    width = abs(fit.loss_factor[m]) * fit.frequency[m] / spacing
    reach = min(max(LEAKED_MODES.lines, LEAKED_MODES.half_power_widths * width), LEAKED_MODES.largest_lines)
    return np.flatnonzero((nearest == m) & (np.abs(freq - fit.frequency[m]) <= reach * spacing))

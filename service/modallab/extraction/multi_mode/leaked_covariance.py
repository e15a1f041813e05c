"""Covariance of modes that are fitted to leaked lines of all FRFs."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, nearest_mode
from modallab.extraction.multi_mode.modal_fit import fitted_receptance
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.multi_mode.settings import LEAKED_MODES
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import SinglePole
from modallab.extraction.preprocessing.leaked_lines import (
    LeakedLines,
    LineErrors,
    leaked_lines,
    white_error_correlation,
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
    receptance = fitted_receptance(fit, band_data.freq, damping)
    nearest, misfit_factor = (
        nearest_mode(fit.eigenvalue, band_data.freq),
        max(float(np.median(fit.misfit)), 1.0),
    )
    for m in range(n):
        index = _lines_of_mode(fit, band_data.freq, m, nearest)
        if len(index) < LEAKED_MODES.minimum_lines:
            continue
        freq, total_receptance = band_data.freq[index], receptance[index].T
        mode = _Mode(fit, m, freq, refined.weight[index].T, total_receptance)
        leaked_lines_of_mode = _lines_about_mode(fit, leaked, m, freq, spacing, total_receptance)
        noise = _noise(band_data, leaked, index, leaked_lines_of_mode, fit.common_noise)
        errors = mode.errors(leaked_lines_of_mode, noise, leaked.averages, fit.common_noise)
        turn = np.array([-fit.loss_factor[m], 1.0]) / fit.eigenvalue[m].real
        variance[m] = misfit_factor * errors.eigenvalue[0, 0] / (8 * np.pi**2 * fit.frequency[m]) ** 2
        variance[n + m] = misfit_factor * (turn @ errors.eigenvalue @ turn)
        constant[m] = np.sqrt(misfit_factor) * errors.constant
    scale = np.sqrt(variance / np.maximum(np.diag(fit.eigenvalue_covariance), SAFE_DIVISOR))
    covariance = fit.eigenvalue_covariance * scale[:, None] * scale
    return replace(fit, eigenvalue_covariance=covariance, modal_constant_error=constant)


@dataclass(frozen=True, eq=False)
class _Errors:
    eigenvalue: FloatArray
    """(2, 2) covariance of real and imaginary part, (rad/s)^4."""
    constant: FloatArray
    """(n_frf,) 1/kg, standard errors of the modulus of the modal constants."""


class _Mode:
    """One mode and the influence of its lines; arrays (n_frf, n_lines)."""

    def __init__(
        self, fit: ModalFit, m: int, freq: FloatArray, weight: FloatArray, total_receptance: ComplexArray
    ) -> None:
        flank = 1 / (fit.eigenvalue[m] - (2 * np.pi * freq) ** 2)
        constant = fit.modal_constant[m]
        power = (weight * np.abs(flank) ** 2).sum(axis=1)
        power = np.where(power > 0, power, np.inf)
        slope = -constant[:, None] * flank**2
        along = (weight * flank.conj() * slope).sum(axis=1) / power
        slope = slope - along[:, None] * flank
        total = float((weight * np.abs(slope) ** 2).sum())
        self._pole_influence = weight * slope.conj() * total_receptance / (total or np.inf)
        size = np.abs(constant)
        turn = constant.conj() / np.where(size > 0, size, 1.0)
        self._constant_influence = turn[:, None] * weight * flank.conj() * total_receptance / power[:, None]
        self._constant_slope = -turn * along

    def errors(self, lines: LeakedLines, noise: "_Noise", averages: float, common: float) -> _Errors:
        """Return the errors of the mode by leakage and noise."""
        line_errors, influence = (
            lines.errors,
            self._constant_influence + self._constant_slope[:, None] * self._pole_influence,
        )
        frf_errors = LineErrors(
            line_errors.covariance * (1 - common) / averages + noise.independent,
            line_errors.relation * (1 - common) / averages,
        )
        pole = np.array(_squares(self._pole_influence, frf_errors))
        other_frfs = pole.sum(axis=1, keepdims=True) - pole
        beta = np.stack([np.abs(self._constant_slope) ** 2, self._constant_slope**2])
        constant = np.array(_squares(influence, frf_errors)) + beta * other_frfs
        total = pole.sum(axis=1)
        if common > 0:
            share = common / averages
            form = np.einsum("jk,jkab->kab", self._pole_influence, lines.form)
            total = total + share * np.array(_sums(LeakedLines(form, lines.moments[0])))
            forms = (
                self._constant_influence[..., None, None] * lines.form
                + self._constant_slope[:, None, None, None] * form
            )
            constant = constant + share * np.array(_sums(LeakedLines(forms, lines.moments)))
            pole_influence = self._pole_influence.sum(axis=0)
            total[0] += _size(pole_influence, noise.white_correlation)
            constant[0] += _size(
                self._constant_influence + self._constant_slope[:, None] * pole_influence,
                noise.white_correlation,
            )
        circular, turned = total[0].real, total[1]
        eigenvalue = np.array([[circular + turned.real, turned.imag], [turned.imag, circular - turned.real]])
        return _Errors(eigenvalue / 2, np.sqrt(np.maximum(constant.sum(axis=0).real / 2, 0.0)))


def _squares(influence: ComplexArray, errors: LineErrors) -> tuple[ComplexArray, ComplexArray]:
    """Return E|e|^2 and E[e^2] of each FRF's sum of lines, both (n_frf,)."""
    conjugate = influence.conj()
    return (
        np.einsum("jk,jkl,jl->j", influence, errors.covariance, conjugate),
        np.einsum("jk,jkl,jl->j", influence, errors.relation, influence),
    )


def _size(influence: ComplexArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...k,kl,...l->...", influence, covariance, influence.conj()).real)


def _sums(lines: LeakedLines) -> tuple[ComplexArray, ComplexArray]:
    """Return E|e|^2 and E[e^2] of the sum of lines, (...)."""
    errors = lines.errors
    return errors.covariance.sum(axis=(-2, -1)), errors.relation.sum(axis=(-2, -1))


@dataclass(frozen=True, eq=False)
class _Noise:
    independent: FloatArray
    """(n_frf, n_lines, n_lines) covariance of the errors specific to each FRF."""
    white_correlation: FloatArray
    """(n_lines, n_lines) correlation of the common white noise."""


def _noise(
    band_data: BandData, leaked: LeakageCorrection, index: IntArray, lines: LeakedLines, common: float
) -> _Noise:
    """Return the errors of lines beside leakage; their common part is at most its median over the FRFs.

    A minimum over many FRFs would be low by chance, because each is the difference of two estimates.
    """
    freq, spacing = band_data.freq[index], float(np.median(np.diff(band_data.freq)))
    exactness = (band_data.weight[index] * np.abs(band_data.receptance[index]) ** 2).T
    line_variance = np.where(exactness > 0, 1 / np.where(exactness > 0, exactness, 1.0), 0.0)
    leaked_variance = np.diagonal(lines.errors.covariance, axis1=-2, axis2=-1).real / leaked.averages
    excess = np.maximum(line_variance - leaked_variance, 0.0)
    common_variance = common * np.median(excess, axis=0)
    correlation = white_error_correlation(leaked.leakage, freq, spacing)

    def tied_by_window(variance: FloatArray) -> FloatArray:
        size = np.sqrt(variance)
        return np.asarray(size[..., :, None] * size[..., None, :] * correlation)

    return _Noise(tied_by_window(np.maximum(excess - common_variance, 0.0)), tied_by_window(common_variance))


def _lines_about_mode(
    fit: ModalFit,
    leaked: LeakageCorrection,
    m: int,
    freq: FloatArray,
    spacing: float,
    receptance: ComplexArray,
) -> LeakedLines:
    """Return the errors of lines by leakage of one mode, in all FRFs; `receptance` (n_frf, n_lines)."""
    x, pole, constant = (2 * np.pi * freq) ** 2, fit.eigenvalue[m], fit.modal_constant[m]
    residual = constant[:, None] - x * (receptance - constant[:, None] / (pole - x))
    eigenvalue, drive_row = fit.eigenvalue[m : m + 1], leaked.drive
    drive = np.zeros(1, complex) if drive_row is None else constant[drive_row : drive_row + 1]
    drive_residual = (
        np.zeros((1, len(freq)), complex) if drive_row is None else residual[drive_row : drive_row + 1]
    )
    return leaked_lines(
        leaked.leakage,
        freq,
        spacing,
        SinglePole(eigenvalue, -pole * constant, residual),
        SinglePole(eigenvalue, -pole * drive, drive_residual),
    )


def _lines_of_mode(fit: ModalFit, freq: FloatArray, m: int, nearest: IntArray) -> IntArray:
    """Return the lines near a mode that are nearest to no other mode."""
    spacing = float(np.median(np.diff(freq)))
    width = abs(fit.loss_factor[m]) * fit.frequency[m] / spacing
    reach = min(max(LEAKED_MODES.lines, LEAKED_MODES.half_power_widths * width), LEAKED_MODES.largest_lines)
    return np.flatnonzero((nearest == m) & (np.abs(freq - fit.frequency[m]) <= reach * spacing))

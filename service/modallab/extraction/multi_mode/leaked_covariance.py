"""What errors of leaked lines do to modes that are fitted to all FRFs at once."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, nearest_mode
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

REACH, WIDTHS = 12, 3.0  # lines to either side that tell of a mode, or half-power bandwidths
MOST, FEWEST = 32, 4  # lines to either side, and in all


def with_leaked_errors(
    refined: RefinedModes, stretch: BandData, leaked: LeakageCorrection, damping: Damping
) -> ModalFit:
    """Return the fit with errors that know how those of leaked lines go together.

    Mode by mode, the others held: what one line's error, or that of all FRFs there, moves the mode by, and
    the moments of these errors near one resonance. Of errors that FRFs have in common the fit knows the
    share. How errors of different modes go together stays as it is.

    Parameters
    ----------
    refined
        Fitted to cleaned lines; a mode that hardly any line tells of keeps its errors.
    stretch
        The lines as they are.
    leaked
        What they were cleaned by.
    damping
        Law of the modes.
    """
    fit, n = refined.fit, len(refined.fit.eigenvalue)
    spacing = float(np.median(np.diff(stretch.freq)))
    variance = np.diag(fit.eigenvalue_covariance).copy()
    constant = fit.modal_constant_error.copy()
    receptance = fitted_receptance(fit, stretch.freq, damping)
    nearest, wide = nearest_mode(fit.eigenvalue, stretch.freq), max(float(np.median(fit.misfit)), 1.0)
    for m in range(n):
        index = _near(fit, stretch.freq, m, nearest)
        if len(index) < FEWEST:
            continue
        freq, whole = stretch.freq[index], receptance[index].T
        mode = _Mode(fit, m, freq, refined.weight[index].T, whole)
        tied = _tied(fit, leaked, m, freq, spacing, whole)
        noise = _noise(stretch, leaked, index, tied, fit.common)
        errors = mode.errors(tied, noise, leaked.averages, fit.common)
        turn = np.array([-fit.loss_factor[m], 1.0]) / fit.eigenvalue[m].real
        variance[m] = wide * errors.eigenvalue[0, 0] / (8 * np.pi**2 * fit.frequency[m]) ** 2
        variance[n + m] = wide * (turn @ errors.eigenvalue @ turn)
        constant[m] = np.sqrt(wide) * errors.constant
    scale = np.sqrt(variance / np.maximum(np.diag(fit.eigenvalue_covariance), 1e-300))
    covariance = fit.eigenvalue_covariance * scale[:, None] * scale
    return replace(fit, eigenvalue_covariance=covariance, modal_constant_error=constant)


@dataclass(frozen=True, eq=False)
class _Errors:
    eigenvalue: FloatArray  # (2, 2) covariance of real and imaginary part, (rad/s)^4
    constant: FloatArray  # (n_frf,) standard errors of their size, 1/kg


class _Mode:
    """One mode, and how it follows the lines that tell of it; arrays (n_frf, n_lines)."""

    def __init__(
        self, fit: ModalFit, m: int, freq: FloatArray, weight: FloatArray, whole: ComplexArray
    ) -> None:
        flank = 1 / (fit.eigenvalue[m] - (2 * np.pi * freq) ** 2)
        constant = fit.modal_constant[m]
        power = (weight * np.abs(flank) ** 2).sum(axis=1)
        power = np.where(power > 0, power, np.inf)
        slope = -constant[:, None] * flank**2
        along = (weight * flank.conj() * slope).sum(axis=1) / power
        slope = slope - along[:, None] * flank
        total = float((weight * np.abs(slope) ** 2).sum())
        self._pole = weight * slope.conj() * whole / (total or np.inf)
        size = np.abs(constant)
        turn = constant.conj() / np.where(size > 0, size, 1.0)
        self._own = turn[:, None] * weight * flank.conj() * whole / power[:, None]
        self._along = -turn * along

    def errors(self, tied: LeakedLines, noise: "_Noise", averages: float, common: float) -> _Errors:
        """Return what leakage and noise do to the mode.

        Parameters
        ----------
        tied
            Lines of one record, of all FRFs.
        noise
            What lines have beside leakage.
        averages
            Records.
        common
            Share of the errors that FRFs have in common.
        """
        each, own = tied.errors, self._own + self._along[:, None] * self._pole
        alone = LineErrors(
            each.covariance * (1 - common) / averages + noise.alone,
            each.relation * (1 - common) / averages,
        )
        pole = np.array(_squares(self._pole, alone))
        others = pole.sum(axis=1, keepdims=True) - pole
        beta = np.stack([np.abs(self._along) ** 2, self._along**2])
        constant = np.array(_squares(own, alone)) + beta * others
        whole = pole.sum(axis=1)
        if common > 0:
            share = common / averages
            form = np.einsum("jk,jkab->kab", self._pole, tied.form)
            whole = whole + share * np.array(_sums(LeakedLines(form, tied.moments[0])))
            forms = self._own[..., None, None] * tied.form + self._along[:, None, None, None] * form
            constant = constant + share * np.array(_sums(LeakedLines(forms, tied.moments)))
            every = self._pole.sum(axis=0)
            whole[0] += _size(every, noise.white_correlation)
            constant[0] += _size(self._own + self._along[:, None] * every, noise.white_correlation)
        circular, turned = whole[0].real, whole[1]
        eigenvalue = np.array([[circular + turned.real, turned.imag], [turned.imag, circular - turned.real]])
        return _Errors(eigenvalue / 2, np.sqrt(np.maximum(constant.sum(axis=0).real / 2, 0.0)))


def _squares(influence: ComplexArray, errors: LineErrors) -> tuple[ComplexArray, ComplexArray]:
    """Return E|e|^2 and E[e^2] of each FRF's sum of lines, both (n_frf,)."""
    back = influence.conj()
    return (
        np.einsum("jk,jkl,jl->j", influence, errors.covariance, back),
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
    alone: FloatArray  # (n_frf, n_lines, n_lines) covariance of what each FRF has for itself
    white_correlation: FloatArray  # (n_lines, n_lines) of what all have in common


def _noise(
    stretch: BandData, leaked: LeakageCorrection, index: IntArray, tied: LeakedLines, common: float
) -> _Noise:
    """Return errors that lines have beside leakage: in common at most what is usual among the FRFs.

    The least of many would be least by chance: each is what an estimate leaves over another.
    """
    freq, spacing = stretch.freq[index], float(np.median(np.diff(stretch.freq)))
    seen = (stretch.weight[index] * np.abs(stretch.receptance[index]) ** 2).T
    known = np.where(seen > 0, 1 / np.where(seen > 0, seen, 1.0), 0.0)
    own = np.diagonal(tied.errors.covariance, axis1=-2, axis2=-1).real / leaked.averages
    more = np.maximum(known - own, 0.0)
    shared = common * np.median(more, axis=0)
    alike = white_error_correlation(leaked.leakage, freq, spacing)

    def tied_by_window(variance: FloatArray) -> FloatArray:
        size = np.sqrt(variance)
        return np.asarray(size[..., :, None] * size[..., None, :] * alike)

    return _Noise(tied_by_window(np.maximum(more - shared, 0.0)), tied_by_window(shared))


def _tied(
    fit: ModalFit, leaked: LeakageCorrection, m: int, freq: FloatArray, spacing: float, whole: ComplexArray
) -> LeakedLines:
    """Return errors that leakage about one mode makes of the lines of all FRFs; `whole` (n_frf, n_lines)."""
    x, pole, constant = (2 * np.pi * freq) ** 2, fit.eigenvalue[m], fit.modal_constant[m]
    beside = constant[:, None] - x * (whole - constant[:, None] / (pole - x))
    one, at = fit.eigenvalue[m : m + 1], leaked.drive
    drive = np.zeros(1, complex) if at is None else constant[at : at + 1]
    beside_drive = np.zeros((1, len(freq)), complex) if at is None else beside[at : at + 1]
    return leaked_lines(
        leaked.leakage,
        freq,
        spacing,
        SinglePole(one, -pole * constant, beside),
        SinglePole(one, -pole * drive, beside_drive),
    )


def _near(fit: ModalFit, freq: FloatArray, m: int, nearest: IntArray) -> IntArray:
    """Return the lines that tell of a mode, and of no other."""
    spacing = float(np.median(np.diff(freq)))
    width = abs(fit.loss_factor[m]) * fit.frequency[m] / spacing
    reach = min(max(REACH, WIDTHS * width), MOST)
    return np.flatnonzero((nearest == m) & (np.abs(freq - fit.frequency[m]) <= reach * spacing))

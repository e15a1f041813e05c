"""Resonances in the residual of a fit of all modes."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING, SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.refinement import BandData, between_ends
from modallab.extraction.multi_mode.refinement_settings import RESIDUAL_POLES
from modallab.extraction.multi_mode.uniform_grid import places

Number = TypeVar("Number", bound=np.generic)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Resonances in a residual."""

    eigenvalue: ComplexArray
    """(n_candidates,) omega_r^2 (1 + i eta_r), (rad/s)^2."""
    participation: ComplexArray | None
    """(n_candidates, n_ref) factors; None with one reference."""

    @property
    def frequency(self) -> FloatArray:
        """(n_candidates,) Hz."""
        return np.asarray(np.sqrt(self.eigenvalue.real) / (2 * np.pi))

    @property
    def width(self) -> FloatArray:
        """(n_candidates,) Hz, half-power bandwidths."""
        return np.asarray(self.frequency * self.eigenvalue.imag / self.eigenvalue.real)

    def at(self, rows: BoolArray) -> "Candidates":
        """Return some of them, (n_candidates,) boolean."""
        reach = self.participation
        return Candidates(self.eigenvalue[rows], None if reach is None else reach[rows])


def residual_poles(band_data: BandData, residual: ComplexArray, fit: ModalFit) -> Candidates | None:
    """Return poles that the residual shows; None if there are none.

    Around every line a resonance with each of several bandwidths is fitted to the residual of all FRFs, with
    one constant in each FRF (matched filter). If noise is independent from line to line, its decrease of the
    squared residual has an F distribution. Noise that an exponential window correlates cannot be
    distinguished from a pole.

    Parameters
    ----------
    band_data
        Lines with their weights before a fit.
    residual
        (n_lines, n_frf) m/N, difference of the lines from the fit.
    fit
        Fit of all modes. Candidates have loss factors like them, because modes of a structure are damped
        alike.
    """
    lines = _lines(band_data, residual)
    n_grid = len(lines.used)
    spacing = float(band_data.freq[-1] - band_data.freq[0]) / max(n_grid - 1, 1)
    centre = band_data.freq[0] + spacing * np.arange(n_grid)
    known = fit.loss_factor[between_ends(fit, band_data.freq) & (fit.loss_factor > 0)]
    least = np.maximum(float(known.min()) / RESIDUAL_POLES.damping_ratio * centre, spacing)
    largest = np.maximum(float(known.max()) * RESIDUAL_POLES.damping_ratio * centre, spacing)
    widths = _widths(float(least[0]), float(largest[-1]))
    scores = np.zeros((len(widths), n_grid))
    for row, width in enumerate(widths):
        size = max(int(width / spacing * RESIDUAL_POLES.group), 1)
        place = np.arange(size // 2, n_grid, size)
        score, excess = _score(lines.grouped(size), width / spacing / size)
        if row == 0 and excess > RESIDUAL_POLES.largest_excess:  # a wide pole meets missing modes everywhere
            return None
        scores[row, place] = score[: len(place)]
    scores[(widths[:, None] < least) | (widths[:, None] > largest)] = 0.0
    rows = _peaks(scores, widths / spacing)
    if not len(rows):
        return None
    width = widths[scores[:, rows].argmax(axis=0)]
    eigenvalue = (2 * np.pi * centre[rows]) ** 2 * (1 + 1j * width / centre[rows])
    return Candidates(eigenvalue, _participation(band_data, residual, centre[rows], width))


@dataclass(frozen=True, eq=False)
class _Lines:
    """Residual on a uniform grid, in which points without a line have no weight."""

    weight: FloatArray
    """(n_grid, n_frf) one over E|error|^2."""
    product: ComplexArray
    """(n_grid, n_frf) residual times weight."""
    square: FloatArray
    """(n_grid,) sum over the FRFs of the squared residual times weight."""
    used: FloatArray
    """(n_grid,) number of FRFs with weight."""

    def grouped(self, size: int) -> "_Lines":
        """Return the sums over groups of so many grid points."""
        if size == 1:
            return self
        first = np.arange(0, len(self.used), size)
        values = (self.weight, self.product, self.square, self.used)
        return _Lines(*(np.add.reduceat(value, first, axis=0) for value in values))


def _lines(band_data: BandData, residual: ComplexArray) -> _Lines:
    grid = places(band_data.freq)
    shape = (int(grid[-1]) + 1, residual.shape[1])
    weight, product = np.zeros(shape), np.zeros(shape, complex)
    weight[grid], product[grid] = band_data.weight, band_data.weight * residual
    square = np.zeros(shape[0])
    square[grid] = (band_data.weight * np.abs(residual) ** 2).sum(axis=1)
    return _Lines(weight, product, square, (weight > 0).sum(axis=1).astype(float))


def _widths(smallest: float, largest: float) -> FloatArray:
    """Return the bandwidths of candidates, Hz, (n_widths,) ascending."""
    n = int(np.ceil(np.log(max(largest / smallest, 1.0)) / np.log(RESIDUAL_POLES.width_step))) + 1
    return np.asarray(smallest * RESIDUAL_POLES.width_step ** np.arange(n))


def _score(lines: _Lines, width: float) -> tuple[FloatArray, float]:
    """Return how improbable it is that noise alone gives a resonance of a width in points, and its excess.

    Minus the decimal logarithm of the probability, (n_grid,); and the decrease of the squared residual in the
    quieter part of the lines over that by independent noise.
    """
    reach = max(int(np.ceil(RESIDUAL_POLES.reach * width)), RESIDUAL_POLES.least_reach)
    kernel = 1 / (width / 2 + 1j * np.arange(-reach, reach + 1))  # a unit residue, 1/(i omega - s)
    if len(kernel) > len(lines.used):
        return np.zeros(len(lines.used)), 1.0
    product = _convolved(lines.product, kernel.conj()[::-1])
    norm = _convolved(lines.weight, np.abs(kernel) ** 2)
    enough = norm > COMPARISON_ROUNDING * norm.max(axis=0)
    gain = np.where(enough, np.abs(product) ** 2 / np.where(enough, norm, 1.0), 0.0).sum(axis=1)
    box, n_frf = np.ones(len(kernel)), enough.sum(axis=1)
    n_left = np.convolve(lines.used, box, mode="same") - n_frf
    left = np.maximum(np.convolve(lines.square, box, mode="same") - gain, SAFE_DIVISOR)
    usable = (n_left > 0) & (n_frf > 0)
    ratio = np.where(usable, gain / left * n_left / np.maximum(n_frf, 1), 0.0)
    degrees_of_freedom = 2 * np.maximum(n_frf, 1), 2 * np.maximum(n_left, 1)
    log = scipy.stats.f.logsf(ratio, *degrees_of_freedom)
    excess = 1.0
    if usable.any():
        quiet, middle = RESIDUAL_POLES.quiet_share, (np.median(part[usable]) for part in degrees_of_freedom)
        excess = float(np.quantile(ratio[usable], quiet) / scipy.stats.f.ppf(quiet, *middle))
    return np.asarray(np.where(usable, -log / np.log(10), 0.0)), excess


def _convolved(values: NDArray[Number], kernel: NDArray[Number]) -> NDArray[Number]:
    """Return the convolution along the grid, (n_grid, n_frf)."""
    return np.asarray(scipy.signal.oaconvolve(values, kernel[:, None], mode="same", axes=0))


def _peaks(scores: FloatArray, widths: FloatArray) -> IntArray:
    """Return the grid points with the highest scores above noise, each highest within its bandwidth."""
    limit = float(np.log10(max(int(np.count_nonzero(scores)), 1) / RESIDUAL_POLES.false_poles))
    best, height = scores.argmax(axis=0), np.asarray(scores.max(axis=0), float)
    at = np.arange(scores.shape[1])
    rows: list[int] = []
    height[at < RESIDUAL_POLES.edge_lines] = height[at >= len(at) - RESIDUAL_POLES.edge_lines] = 0.0
    while height.max() > limit and len(rows) < RESIDUAL_POLES.most_candidates:
        row = int(height.argmax())
        rows.append(row)
        reach = max(RESIDUAL_POLES.reach * widths[best[row]], RESIDUAL_POLES.least_reach)
        height[np.abs(at - row) <= reach] = 0.0
    return np.sort(np.array(rows, int))


def _participation(
    band_data: BandData, residual: ComplexArray, frequency: FloatArray, width: FloatArray
) -> ComplexArray | None:
    """Return the participation factors of resonances in a residual, (n_candidates, n_ref)."""
    if band_data.n_ref == 1:
        return None
    resonance = 1 / (width / 2 - 1j * (band_data.freq[:, None] - frequency))
    constants = resonance.T @ (band_data.weight * residual)
    norm = (np.abs(resonance) ** 2).T @ band_data.weight
    by_dof = (constants / np.maximum(norm, SAFE_DIVISOR)).reshape(len(frequency), -1, band_data.n_ref)
    return np.asarray(np.linalg.svd(by_dof, full_matrices=False)[2][:, 0])

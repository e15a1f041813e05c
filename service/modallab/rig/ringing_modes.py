"""Modes that ring on beyond a record: poles and residues of the spectra that they dominate."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.rig.record_settings import RINGING

Spectra = Callable[[FloatArray], ComplexArray]  # (n,) Hz -> (n, k)


@dataclass(frozen=True, eq=False)
class RingingModes:
    """Free decays of k signals after an impulse at sample 0: amplitude exp(2 pi i pole t) + conjugate."""

    poles: ComplexArray
    """(n_modes,) samples^-1, of positive imaginary part: cycles and decay a sample."""
    amplitudes: ComplexArray
    """(n_modes, k) of the samples."""

    def lines_after(self, first: int, n_lines: int, n: int) -> ComplexArray:
        """Return the transform (n_lines, k) at the lines of n samples, of all samples from `first` on.

        The sum of A z^j over j >= first, z = exp(2 pi i (pole - line/n)): A z^first / (1 - z).
        """
        step = np.exp(-2j * np.pi * np.arange(n_lines) / n)
        turns = np.exp(-2j * np.pi * (np.arange(n_lines) * first % n) / n)
        poles = np.concatenate([self.poles, -self.poles.conj()])
        amplitudes = np.concatenate([self.amplitudes, self.amplitudes.conj()])
        remaining = amplitudes * np.exp(2j * np.pi * first * poles)[:, None]
        return np.asarray((turns[:, None] / (1 - step[:, None] * np.exp(2j * np.pi * poles))) @ remaining)

    def aliases(self, period: int) -> FloatArray:
        """Return what wraps into the samples -period/2 to period/2 of a transform of a period, (period, k).

        Every period that the decay lasts beyond the first: A z^(j + m period), m = 1, 2, ...
        """
        samples = np.arange(period) - period // 2
        period_factor = np.exp(2j * np.pi * self.poles * period)
        wrapped = self.amplitudes * (period_factor / (1 - period_factor))[:, None]
        return np.asarray(2 * (np.exp(2j * np.pi * self.poles * samples[:, None]) @ wrapped).real)


def ringing_modes(spectra: Spectra, frequencies: FloatArray, widths: FloatArray, n: int) -> RingingModes:
    """Return the modes of some spectra that ring on for longer than a record.

    Around each group of narrow resonances a ratio of polynomials goes through the spectra, exactly but for
    rounding; its poles need no eigensolution, its residues no modal model.

    Parameters
    ----------
    spectra
        Transforms of the samples' impulse responses by frequency in lines.
    frequencies, widths
        (n_modes,) and half the half-power bandwidth, lines: where to look.
    n
        Samples of a record.
    """
    slow = (widths < RINGING.widest) & (frequencies < n / 2 - RINGING.reach)
    regions = list(_regions(frequencies[slow]))
    nodes = [_nodes(low, high, count) for low, high, count in regions]
    values = spectra(np.concatenate(nodes))
    poles, amplitudes = [], []
    edges = np.cumsum([len(part) for part in nodes])[:-1]
    for (low, high, count), part in zip(regions, np.split(values, edges), strict=True):
        pole, residue = _rational_fit(part, count)
        pole, residue = (low + high) / 2 + (high - low) / 2 * pole, (high - low) / 2 * residue
        inside = (pole.real > low - RINGING.aperiodic * (high - low)) & (pole.real < high)
        rings = inside & (pole.imag >= 0) & (pole.imag < RINGING.widest)
        # A motion that dies away without a resonance is its own conjugate.
        share = np.where(np.abs(pole.real) < RINGING.aperiodic * (high - low), 0.5, 1.0)
        poles.append(pole[rings] / n)
        amplitudes.append(2j * np.pi / n * (share[:, None] * residue)[rings])
    return RingingModes(np.concatenate(poles), np.concatenate(amplitudes))


def _regions(frequencies: FloatArray) -> Iterator[tuple[float, float, int]]:
    """Yield the ends, lines, of the regions of groups of resonances, and how many lie in each.

    The lowest begins at 0 Hz, where motions without a resonance die away slowly too.
    """
    reach = RINGING.reach
    low, high, count = 0.0, 2 * reach, 2
    for frequency in np.sort(frequencies):
        if frequency - reach < high:
            high, count = max(high, frequency + reach), count + (2 if low == 0.0 else 1)
            continue
        yield low, high, count
        low, high, count = frequency - reach, frequency + reach, 1
    yield low, high, count


def _nodes(low: float, high: float, count: int) -> FloatArray:
    """Return Chebyshev points (n,) between two ends for a number of resonances."""
    n = RINGING.nodes_per_unknown * (2 * (count + RINGING.spare_poles) + RINGING.background)
    return np.asarray((low + high) / 2 - (high - low) / 2 * np.cos(np.pi * (np.arange(n) + 0.5) / n))


def _rational_fit(values: ComplexArray, count: int) -> tuple[ComplexArray, ComplexArray]:
    """Return poles (m,) and residues (m, k) of values (n, k) at Chebyshev points of -1 to 1.

    Values times denominator are a polynomial: what of them is orthogonal to polynomials is zero, a linear
    condition on the denominator that all columns share. Levy (1959), IRE Trans. Automatic Control 4, 37-43.
    """
    n = len(values)
    place = -np.cos(np.pi * (np.arange(n) + 0.5) / n)
    degree = count + RINGING.spare_poles
    size = np.maximum(np.abs(values).max(axis=0), SAFE_DIVISOR)
    scaled = values / size
    weight = 1 / np.maximum(np.abs(scaled).max(axis=1), SAFE_DIVISOR)
    denominator_basis = chebyshev.chebvander(place, degree)
    numerator_basis = weight[:, None] * chebyshev.chebvander(place, degree + RINGING.background)
    orthogonal, triangle = np.linalg.qr(numerator_basis, mode="complete")
    n_terms = numerator_basis.shape[1]
    products = (weight[:, None] * scaled)[:, :, None] * denominator_basis[:, None, :]
    remainders = orthogonal[:, n_terms:].T @ products.reshape(n, -1)
    denominator = np.linalg.svd(remainders.reshape(-1, degree + 1), full_matrices=False)[2][-1].conj()
    numerator = np.linalg.solve(triangle[:n_terms], orthogonal[:, :n_terms].T @ (products @ denominator))
    poles = chebyshev.chebroots(denominator)
    poles = poles[np.abs(poles) < 1 + RINGING.widest]
    slope = chebyshev.chebval(poles, chebyshev.chebder(denominator))
    residues = chebyshev.chebval(poles, numerator).T / slope[:, None]
    return poles, residues * size

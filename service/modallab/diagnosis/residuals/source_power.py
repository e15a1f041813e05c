"""Power of the sources where the log book leaves it open: a smooth factor on the expected spectra."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import BSpline

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.residuals.settings import FREE_LEVELS
from modallab.estimation.spectra import CrossSpectra

if TYPE_CHECKING:
    from modallab.diagnosis.residuals.observed import Observed


@dataclass(frozen=True, eq=False)
class SourcePower:
    """Least-squares fits of the logarithm of each source's power to measured force spectra."""

    freq: FloatArray
    """(n_freq,) measured lines, Hz."""
    measured: FloatArray
    """(n_freq, n_force), logarithms of the force spectra, N^2/Hz; 0 where a spectrum is not used."""
    used: BoolArray
    """(n_freq, n_force): lines that a source is fitted at."""
    projections: FloatArray
    """(n_force, n, n_freq), least-squares coefficients of n functions by the logarithms at each line."""
    correlation: ComplexArray | None
    """(n_run, n_freq, n_in, n_in), G_ff over its diagonal of sources of unknown shape; None: as expected."""

    @classmethod
    def of(cls, observed: "Observed") -> "SourcePower | None":
        """Return the fits to a measurement; None if it has no force spectra."""
        force = observed.force
        if force is None:
            return None
        used = _lines_of_forces(observed, force.shape[1])
        weights = np.where(used, 1 / np.sqrt(np.broadcast_to(observed.force_variance, force.shape)), 0.0)
        shape = observed.free_levels.shape
        basis = source_functions(observed.freq, observed.freq, shape=shape)
        projections = np.asarray(np.linalg.pinv(weights.T[:, :, None] * basis), float) * weights.T[:, None, :]
        correlation = observed.force_correlation if shape else None
        return cls(observed.freq, np.log(np.where(used, force, 1.0)), used, projections, correlation)

    def applied(self, spectra: CrossSpectra, lines: IntArray | None) -> CrossSpectra:
        """Return expected spectra with the power that fits the measured force spectra best.

        Sources whose shape is open may have anything in common: their forces are correlated as measured.

        Parameters
        ----------
        lines
            (n,) indices of the measured lines among those of the spectra; None: all.
        """
        at_lines = spectra if lines is None else spectra.at(lines)
        n_run, n_in = spectra.ff.shape[0], spectra.ff.shape[2]
        expected = force_spectra(at_lines).swapaxes(0, 1).reshape(self.measured.shape)
        ratio = np.where(self.used, self.measured - np.log(np.where(self.used, expected, 1.0)), 0.0)
        coefficients = self.projections @ ratio.T[:, :, None]
        shape = self.projections.shape[1] > 1
        functions = source_functions(spectra.freq, self.freq, shape=shape)
        power = np.exp(coefficients[..., 0] @ functions.T)
        powered = _with_power(spectra, power.reshape(n_run, n_in, -1).swapaxes(1, 2))
        if self.correlation is None:
            return powered
        size, ff = np.sqrt(force_spectra(powered)), powered.ff.copy()
        at = slice(None) if lines is None else lines
        ff[:, at] = size[:, at, :, None] * self.correlation * size[:, at, None, :]
        return _with_forces(powered, ff)

    def project(self, changes: FloatArray) -> FloatArray:
        """Return the projection of changes of logarithms of force spectra on the functions of the power.

        Parameters
        ----------
        changes
            (n, n_freq, n_force) at the measured lines.
        """
        used = np.where(self.used, changes, 0.0)
        coefficients = self.projections @ np.moveaxis(used, 2, 1)[..., None]
        shape = self.projections.shape[1] > 1
        functions = source_functions(self.freq, self.freq, shape=shape)
        return np.asarray(np.moveaxis(coefficients[..., 0] @ functions.T, 1, 2))


def shape_variance(freq: FloatArray, force: FloatArray, used: BoolArray) -> FloatArray:
    """Return the least variances (n_force,) of the logarithms of spectra of forces of unknown shape.

    A pulse or an amplifier is no sum of a few B-splines, however small the random error. The deviation from
    them is taken from the spectra, up to what a source may have.

    Parameters
    ----------
    force
        (n_freq, n_force), N^2/Hz.
    used
        (n_freq, n_force), lines that show the source.
    """
    functions, variances = source_functions(freq, freq, shape=True), []
    for column, shown in zip(force.T, used.T, strict=True):
        basis, logarithm = functions[shown], np.log(column[shown])
        coefficients = np.linalg.lstsq(basis, logarithm, rcond=None)[0]
        variances.append(((logarithm - basis @ coefficients) ** 2).sum() / max(shown.sum(), 1))
    return np.asarray(np.clip(variances, 0.0, FREE_LEVELS.shape_error**2), float)


def source_functions(freq: FloatArray, measured: FloatArray, *, shape: bool) -> FloatArray:
    """Return the functions (n_freq, n) whose sum is the logarithm of a source's power.

    Cubic B-splines over the measured lines, constant beyond; one constant if the shape is declared.

    Parameters
    ----------
    measured
        Frequencies of the measured lines, Hz.
    shape
        Whether the shape of the spectrum is open.
    """
    n = min(FREE_LEVELS.max_functions, len(measured) // FREE_LEVELS.lines_per_function)
    if not shape or n < FREE_LEVELS.min_functions:
        return np.ones((len(freq), 1))
    low, high = float(measured[measured > 0][0]), float(measured[-1])
    inner = np.linspace(low, high, n - 2)
    knots = np.concatenate([[low] * 3, inner, [high] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(freq, low, high), knots, 3).toarray())


def force_spectra(spectra: CrossSpectra) -> FloatArray:
    """Return the auto spectra of the forces, (n_run, n_freq, n_in)."""
    own = np.arange(spectra.ff.shape[2])
    return spectra.ff[..., own, own].real


def _with_power(spectra: CrossSpectra, power: FloatArray) -> CrossSpectra:
    """Return spectra with the power of each force changed by a factor, H1 and multiple coherence as before.

    Parameters
    ----------
    power
        (n_run, n_freq, n_in).
    """
    if power.shape[2] == 1:
        return replace(
            spectra,
            ff=spectra.ff * power[..., None],
            fx=spectra.fx * power[..., None],
            xx=spectra.xx * power,
        )
    root = np.sqrt(power)
    return _with_forces(spectra, root[..., :, None] * spectra.ff * root[..., None, :])


def _with_forces(spectra: CrossSpectra, ff: ComplexArray) -> CrossSpectra:
    """Return spectra with other forces (n_run, n_freq, n_in, n_in), H1 and multiple coherence as before."""
    h = np.linalg.solve(spectra.ff, spectra.fx)
    fx = ff @ h
    before, after = ((part.conj() * h).sum(axis=2).real for part in (spectra.fx, fx))
    ratio = np.where(before > 0, after, 1.0) / np.where(before > 0, before, 1.0)
    return replace(spectra, ff=ff, fx=fx, xx=spectra.xx * ratio)


def _lines_of_forces(observed: "Observed", n_force: int) -> BoolArray:
    """Return the lines (n_freq, n_force) that a source is fitted at."""
    usable = observed.usable & ~observed.held_out_lines[:, None]
    return np.asarray(usable.reshape(len(usable), n_force, -1).any(axis=2))

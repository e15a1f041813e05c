"""Correlation of residuals from line to line, for the errors of parameters fitted to them."""

import numpy as np
import scipy
from scipy.sparse import coo_array

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.residuals.autocorrelation import autocovariance
from modallab.diagnosis.residuals.residual import Residual
from modallab.diagnosis.residuals.settings import LINE_CORRELATION


class LineCorrelation:
    """The correlation of the residuals of a fit from line to line.

    Estimated from the residuals themselves and tapered by Bartlett's window so that no variance is
    negative: Newey and West, Econometrica 55 (1987), 703-708. A window mixes all lines alike, so one
    correlation holds for each part. Leakage is a few random numbers at every resonance, in many lines and
    in all channels of a run, and absent elsewhere: there every line enters with its own score.
    """

    def __init__(self, residual: Residual, mask: BoolArray) -> None:
        self._kind = _Scores(residual, mask) if residual.lines_correlated else _Pooled(residual, mask)

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of orthonormal columns (n_data, n) with the residuals' correlation R."""
        return self._kind.between(columns)


class _Scores:
    """Contributions of a run's residuals in a line to each column, all channels and parts together.

    Residuals of high leverage are divided by 1 - leverage, summed over the lines that a window mixes:
    MacKinnon and White, Journal of Econometrics 29 (1985), 305-325, HC3.
    """

    def __init__(self, residual: Residual, mask: BoolArray) -> None:
        n_lines = len(mask)
        line, series, _ = _labels(residual, mask)
        run_of_channel = residual.run_of_channel
        n_run = int(run_of_channel.max()) + 1
        first_of_force = np.unique(residual.force_of_channel, return_index=True)[1]
        no_forces = np.zeros(0, int)
        run = _run(
            series, run_of_channel, no_forces if residual.force is None else run_of_channel[first_of_force]
        )
        self._vector = residual.vector(mask)
        self._mean_square = max(1.0, float(self._vector @ self._vector) / len(self._vector))
        self._shape = (n_run, n_lines)
        ranges = (
            _correlation_range(part, residual.mask_of(name, mask), n_run)
            for name, part in residual.parts.items()
        )
        self._range = max(LINE_CORRELATION.score_lags, *ranges)
        entry = run * n_lines + line, np.arange(len(line))
        self._sums = coo_array((np.ones(len(line)), entry), shape=(n_run * n_lines, len(line))).tocsr()

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T C U with the residuals' covariance C over their mean square, if that is above 1."""
        n, width = columns.shape[1], LINE_CORRELATION.leverage_lines
        weight = (self._sums @ np.sum(columns**2, axis=1)).reshape(self._shape)
        leverage = width * scipy.ndimage.uniform_filter1d(weight, width, axis=1, mode="constant")
        scores = (self._sums @ (columns * self._vector[:, None])).reshape(*self._shape, n)
        scores /= 1 - leverage.clip(0.0, LINE_CORRELATION.max_leverage)[..., None]
        short = _tapered(scores, LINE_CORRELATION.score_lags)
        long = _tapered(scores, self._range)
        # Long lags miss the variance that the fit takes out of all lines together: they count only in the
        # directions in which they show a larger one.
        excess, rotation = np.linalg.eigh(long - short)
        return np.asarray(short + (rotation * np.maximum(excess, 0.0)) @ rotation.T) / self._mean_square


def _correlation_range(part: ComplexArray | FloatArray, mask: BoolArray, n_run: int) -> int:
    """Return the lag in lines at which the taper of a part ends: 1.5 times its last significant one."""
    n = len(part)
    covariance = autocovariance(np.where(mask, part, 0)).real[: max(n // LINE_CORRELATION.leakage_range, 1)]
    count = n * n_run
    bound = LINE_CORRELATION.significance * np.sqrt(np.log10(count) / count)
    threshold = bound * max(float(covariance[0]), SAFE_DIVISOR)
    if not covariance[0] > 0:
        return 0
    return int(LINE_CORRELATION.leakage_extension * int(np.flatnonzero(np.abs(covariance) >= threshold)[-1]))


def _tapered(scores: FloatArray, lags: int) -> FloatArray:
    """Return the covariance (n, n) of the sums over all lines of scores (n_run, n_lines, n)."""
    n_run, n_lines, n = scores.shape
    total = np.zeros((n, n))
    for lag in range(min(lags + 1, n_lines)):
        flat = (n_run * (n_lines - lag), n)
        late, early = scores[:, lag:].reshape(flat), scores[:, : n_lines - lag].reshape(flat)
        product = (1 - lag / (lags + 1)) * early.T @ late
        total += product if lag == 0 else product + product.T
    return total


class _Pooled:
    """One correlation for all lines and channels of a part."""

    def __init__(self, residual: Residual, mask: BoolArray) -> None:
        self._line, self._series, part = _labels(residual, mask)
        self._shape = (int(self._series.max()) + 1, len(mask))
        part_of = np.zeros(self._shape[0], int)
        part_of[self._series] = part
        values = self._by_series(residual.vector(mask)[:, None])[..., 0]
        lags = LINE_CORRELATION.pooled_lags
        self._weights = np.zeros((lags + 1, self._shape[0], 1, 1))
        for part_number in np.unique(part_of):
            series = values[part_of == part_number]
            products = [np.sum(series[:, k:] * series[:, : series.shape[1] - k]) for k in range(lags + 1)]
            taper = 1 - np.arange(lags + 1) / (lags + 1)
            weights = taper * np.array(products) / max(products[0], SAFE_DIVISOR)
            self._weights[:, part_of == part_number, 0, 0] = weights[:, None]

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U, (n, n)."""
        u = self._by_series(columns)
        n_lines, n = self._shape[1], columns.shape[1]
        total = np.zeros((n, n))
        for lag, weights in enumerate(self._weights[:n_lines]):
            early, late = (weights * u)[:, : n_lines - lag].reshape(-1, n), u[:, lag:].reshape(-1, n)
            product = early.T @ late
            total += product if lag == 0 else product + product.T
        return total

    def _by_series(self, columns: FloatArray) -> FloatArray:
        """Return entries (n_data, n) by series and line, (n_series, n_lines, n), 0 where there is none."""
        out = np.zeros((*self._shape, columns.shape[1]))
        out[self._series, self._line] = columns
        return out


def _labels(residual: Residual, mask: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return line, series and part of every entry of a residual's vector, (n_data,) each.

    A series is a channel's real or imaginary part, a force or a response spectrum.
    """
    n_lines, n_out = mask.shape
    line = np.arange(n_lines)[:, None]
    n_force = 0 if residual.force is None else residual.force.shape[1]
    channel, of_force = np.arange(n_out)[None], 2 * n_out + np.arange(n_force)[None]

    def as_vector(frf: IntArray, frf_imag: IntArray, force: IntArray, response: IntArray) -> IntArray:
        labels = Residual(
            np.broadcast_to((frf + 1j * frf_imag) / np.sqrt(2), mask.shape),
            None if residual.force is None else np.broadcast_to(force.astype(float), residual.force.shape),
            None if residual.response is None else np.broadcast_to(response.astype(float), mask.shape),
            forces=residual.force_of_channel,
            response_once=residual.response_once,
        )
        return np.asarray(np.rint(labels.vector(mask)), int)

    unit = np.ones((1, 1), int)
    lines = as_vector(line, line, line, line)
    series = as_vector(channel, n_out + channel, of_force if n_force else unit, 2 * n_out + n_force + channel)
    parts = as_vector(0 * unit, 0 * unit, unit, 2 * unit)
    return lines, series, parts


def _run(series: IntArray, runs: IntArray, runs_of_forces: IntArray) -> IntArray:
    """Return the run that each series belongs to; see `_labels`.

    Parameters
    ----------
    runs
        (n_out,) number of each channel's run.
    runs_of_forces
        (n_force,) number of each force spectrum's run.
    """
    return np.concatenate([runs, runs, runs_of_forces, runs])[series]

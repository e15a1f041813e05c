"""How residuals of near lines go together, and what that does to the errors of what is fitted to them."""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.sparse import coo_array

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.residuals.residual import Residual, autocovariance

LAGS = 12  # lines apart
LAGS_TIED = 8  # the same where every line tells for itself
FARTHEST = 4  # of the band, over one part of so many of which leakage from a resonance may be in step
CERTAIN = 2.0  # times sqrt(log10(n) / n): a correlation of n lines that is none of chance (Politis 2003)
MIXED = 5  # lines that a window mixes
MOST = 0.7  # leverage that a residual is made up for


class LineCorrelation:
    """The correlation of the residuals of a fit from line to line.

    Estimated from the residuals themselves and tapered by Bartlett's window so that no variance is
    negative: Newey and West, Econometrica 55 (1987), 703-708. A window mixes all near lines alike, so
    that each part is taken as one. Leakage is another matter: it is of a few random numbers at every
    resonance, in many lines and in all channels of a run, and elsewhere there is none of it.
    """

    def __init__(self, left: Residual, where: BoolArray) -> None:
        self._kind = _Scores(left, where) if left.lines_correlated else _Pooled(left, where)

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of orthonormal columns (n_data, n) with the residuals' correlation R."""
        return self._kind.between(columns)


class _Scores:
    """What a run's residuals in a line add to each column, of all channels and parts together.

    What a fit took out of residuals that weigh much in it is made up for by their leverage, taken of the
    lines that a window mixes: MacKinnon and White, Journal of Econometrics 29 (1985), 305-325, HC3.
    """

    def __init__(self, left: Residual, where: BoolArray) -> None:
        n_lines, n_out = where.shape
        line, series, _ = _places(left, where)
        n_run = 1 if left.force is None else left.force.shape[1]
        run = _channel(series, n_out, n_run) if n_run == n_out else np.zeros_like(series)
        self._vector = left.vector(where)
        self._size = max(1.0, float(self._vector @ self._vector) / len(self._vector))
        self._shape = (n_run, n_lines)
        self._reach = max(LAGS_TIED, *(_reach(part, where, n_run) for part in left.parts.values()))
        place = run * n_lines + line, np.arange(len(line))
        self._sums = coo_array((np.ones(len(line)), place), shape=(n_run * n_lines, len(line))).tocsr()

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T C U with the residuals' covariance C over their mean square, if that is above 1."""
        n = columns.shape[1]
        weight = (self._sums @ np.sum(columns**2, axis=1)).reshape(self._shape)
        leverage = MIXED * uniform_filter1d(weight, MIXED, axis=1, mode="constant")
        scores = (self._sums @ (columns * self._vector[:, None])).reshape(*self._shape, n)
        scores /= 1 - leverage.clip(0.0, MOST)[..., None]
        near = _tapered(scores, LAGS_TIED)
        far = _tapered(scores, self._reach)
        # What a fit takes out of all lines together far lags miss: they count where they show more.
        more, turn = np.linalg.eigh(far - near)
        return np.asarray(near + (turn * np.maximum(more, 0.0)) @ turn.T) / self._size


def _reach(part: ComplexArray | FloatArray, where: BoolArray, n_run: int) -> int:
    """Return over how many lines residuals of a part go together: half as far again as they do surely."""
    seen = where if part.shape[1] == where.shape[1] else where.any(axis=1, keepdims=True)
    n = len(part)
    covariance = autocovariance(np.where(seen, part, 0)).real[: max(n // FARTHEST, 1)]
    count = n * n_run
    certain = CERTAIN * np.sqrt(np.log10(count) / count) * max(float(covariance[0]), 1e-300)
    return 3 * int(np.flatnonzero(np.abs(covariance) >= certain)[-1]) // 2 if covariance[0] > 0 else 0


def _tapered(scores: FloatArray, lags: int) -> FloatArray:
    """Return the covariance (n, n) of the sums over all lines of scores (n_run, n_lines, n)."""
    n_run, n_lines, n = scores.shape
    total = np.zeros((n, n))
    for lag in range(min(lags + 1, n_lines)):
        flat = (n_run * (n_lines - lag), n)
        late, early = scores[:, lag:].reshape(flat), scores[:, : n_lines - lag].reshape(flat)
        both = (1 - lag / (lags + 1)) * early.T @ late
        total += both if lag == 0 else both + both.T
    return total


class _Pooled:
    """One correlation for all lines and channels of a part."""

    def __init__(self, left: Residual, where: BoolArray) -> None:
        self._line, self._series, part = _places(left, where)
        self._shape = (int(self._series.max()) + 1, len(where))
        part_of = np.zeros(self._shape[0], int)
        part_of[self._series] = part
        spread = self._laid_out(left.vector(where)[:, None])[..., 0]
        self._shares = np.zeros((LAGS + 1, self._shape[0], 1, 1))
        for which in np.unique(part_of):
            own = spread[part_of == which]
            products = [np.sum(own[:, lag:] * own[:, : own.shape[1] - lag]) for lag in range(LAGS + 1)]
            taper = 1 - np.arange(LAGS + 1) / (LAGS + 1)
            shares = taper * np.array(products) / max(products[0], 1e-300)
            self._shares[:, part_of == which, 0, 0] = shares[:, None]

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U."""
        u = self._laid_out(columns)
        n_lines, n = self._shape[1], columns.shape[1]
        total = np.zeros((n, n))
        for lag, shares in enumerate(self._shares[:n_lines]):
            early, late = (shares * u)[:, : n_lines - lag].reshape(-1, n), u[:, lag:].reshape(-1, n)
            both = early.T @ late
            total += both if lag == 0 else both + both.T
        return total

    def _laid_out(self, columns: FloatArray) -> FloatArray:
        """Return entries (n_data, n) by series and line, (n_series, n_lines, n), 0 where there is none."""
        out = np.zeros((*self._shape, columns.shape[1]))
        out[self._series, self._line] = columns
        return out


def _places(left: Residual, where: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return line, series and part of every entry of a residual's vector.

    A series is a channel's real or imaginary part, a force or a response spectrum.
    """
    n_lines, n_out = where.shape
    line = np.arange(n_lines)[:, None]
    n_run = 0 if left.force is None else left.force.shape[1]
    channel, run = np.arange(n_out)[None], 2 * n_out + np.arange(n_run)[None]

    def labelled(frf: IntArray, frf_imag: IntArray, force: IntArray, response: IntArray) -> IntArray:
        label = Residual(
            np.broadcast_to((frf + 1j * frf_imag) / np.sqrt(2), where.shape),
            None if left.force is None else np.broadcast_to(force.astype(float), left.force.shape),
            None if left.response is None else np.broadcast_to(response.astype(float), where.shape),
        )
        return np.asarray(np.rint(label.vector(where)), int)

    one = np.ones((1, 1), int)
    lines = labelled(line, line, line, line)
    series = labelled(channel, n_out + channel, run if n_run else one, 2 * n_out + n_run + channel)
    parts = labelled(0 * one, 0 * one, one, 2 * one)
    return lines, series, parts


def _channel(series: IntArray, n_out: int, n_run: int) -> IntArray:
    """Return which channel, or which run's force, each series is of; see `_places`."""
    return np.where(series < 2 * n_out + n_run, series % n_out, series - 2 * n_out - n_run)

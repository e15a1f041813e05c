"""Whether natural frequencies wander from FRF to FRF, and what moves them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.extraction.averaging.means import beyond_chance, chi_squares

UNSEEN = 0.002  # of a bandwidth: what tails of other modes leave in single-mode fits of exact data
CLEAR = 5.0  # standard errors, of what is named as the cause
MOST = 0.5  # of the chi-square: a cause that leaves more is not the cause


@dataclass(frozen=True, eq=False)
class FittedModes:
    """What the FRFs say of each mode, all (n_modes, n_frf); `good` are the fits that count."""

    frequency: FloatArray  # Hz
    frequency_error: FloatArray  # Hz
    loss_factor: FloatArray
    good: BoolArray
    shape: ComplexArray  # 1/sqrt(kg) if `scaled`
    shape_error: FloatArray
    scaled: bool  # mass-normalised

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the plain mean of the good ones, (n_modes, 1)."""
        count = np.maximum(self.good.sum(axis=1, keepdims=True), 1)
        return np.asarray(np.where(self.good, values, 0.0).sum(axis=1, keepdims=True) / count)

    @property
    def shift(self) -> FloatArray:
        """Change of eigenvalue relative to that of the mean frequency; 0 where a fit does not count."""
        mean = self.mean(self.frequency)
        return np.where(self.good, (self.frequency / np.where(mean > 0, mean, 1.0)) ** 2 - 1, 0.0)

    @property
    def shift_error(self) -> FloatArray:
        """Standard error of `shift`, with what no fit's own error holds."""
        mean = self.mean(self.frequency)
        error = np.hypot(self.frequency_error, UNSEEN * self.mean(self.loss_factor) * mean)
        return np.asarray(2 * error / np.where(mean > 0, mean, 1.0))


@dataclass(frozen=True, eq=False)
class _Law:
    """Relative eigenvalues fitted as `level - slope regressor`, in each mode alone and in all together."""

    mode_slope: FloatArray  # (n_modes,) NaN where a mode does not tell
    mode_error: FloatArray  # (n_modes,)
    slope: float
    error: float
    mode_level: FloatArray  # (n_modes,) with slopes of their own
    level: FloatArray  # (n_modes,) with the common slope
    mode_left: FloatArray  # (n_modes,) chi-square that stays with slopes of their own
    left: float  # chi-square that stays with the common slope
    total: float  # chi-square without a law


def find_frequency_inconsistency(modes: FittedModes) -> FrequencyInconsistency | None:
    """Return how the frequencies wander, None where random error explains their differences.

    A mass m that moves with the response makes the eigenvalue at position j
    `lambda_j = lambda (1 - m phi_j^2)`, phi being the mode's mass-normalised shape there: the first order
    in m. A structure that changes during the test has `lambda_j = lambda (1 + 2 d t_j)` in all modes, t
    from 0 at the first FRF to 1 at the last. Each law is fitted to the relative shifts of all modes by
    weighted least squares, and named if it is clear by five standard errors, widened by the misfit, and
    explains at least half of the chi-square.
    """
    degrees = np.maximum(modes.good.sum(axis=1) - 1, 0)
    total, rest = chi_squares(modes.shift, _weight(modes, modes.shift_error))
    if not beyond_chance(float(total.sum()), int(degrees.sum())):
        return None
    cause, law, explained = _named(modes, total, int(degrees.sum()))
    # one FRF of its own is no wander: without the furthest of each mode the rest must differ too
    if law is None and not beyond_chance(float(rest.sum()), int(np.maximum(degrees - 1, 0).sum())):
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


def _named(
    modes: FittedModes, total: FloatArray, degrees: int
) -> tuple[InconsistencyCause, _Law | None, float]:
    """Return the cause, its law and the part of chi-square that it explains; UNKNOWN if none does."""
    position = np.linspace(0.0, 1.0, modes.good.shape[1])[None].repeat(len(total), axis=0)
    squared = (modes.shape**2).real
    mass = _fitted(modes, squared, modes.shift_error)
    # the regressor has errors too: they count as the shift that they would make
    blurred = np.hypot(modes.shift_error, 2 * mass.slope * np.abs(modes.shape) * modes.shape_error)
    mass = _fitted(modes, squared, blurred)
    found: list[tuple[float, InconsistencyCause, _Law]] = []
    for cause, law in (
        (InconsistencyCause.ROVING_MASS if modes.scaled else InconsistencyCause.SQUARED_SHAPE, mass),
        (InconsistencyCause.STEADY_DRIFT, _fitted(modes, position, modes.shift_error)),
    ):
        own = cause is InconsistencyCause.SQUARED_SHAPE  # without scale every mode has its own slope
        left = float(law.mode_left.sum()) if own else law.left
        spare = degrees - (len(total) if own else 1)
        gain, explained = law.total - left, 1 - left / max(law.total, 1e-300)
        if spare > 0 and explained >= MOST and gain > CLEAR**2 * max(left / spare, 1.0):
            found.append((explained, cause, law))
    if not found:
        return InconsistencyCause.UNKNOWN, None, 0.0
    explained, cause, law = max(found, key=lambda entry: entry[0])
    return cause, law, explained


def _fitted(modes: FittedModes, regressor: FloatArray, error: FloatArray) -> _Law:
    weight = _weight(modes, error)
    x, y = _centred(regressor, weight), _centred(modes.shift, weight)
    xx, xy, yy = (np.asarray((weight * product).sum(axis=1)) for product in (x * x, x * y, y * y))
    some = xx > 0
    own = np.where(some, -xy / np.where(some, xx, 1.0), 0.0)
    mode_left = np.maximum(yy - own**2 * xx, 0.0)
    common = float(-xy.sum() / xx.sum()) if some.any() else 0.0
    left = float((yy + 2 * common * xy + common**2 * xx).sum())
    spare = np.maximum(modes.good.sum(axis=1) - 2, 1)
    mode_error = np.sqrt(np.maximum(mode_left / spare, 1) / np.where(some, xx, 1.0))
    scatter = max(left / max(int((modes.good.sum(axis=1) - 1).sum()) - 1, 1), 1.0)
    return _Law(
        mode_slope=np.where(some, own, np.nan),
        mode_error=np.where(some, mode_error, np.nan),
        slope=common,
        error=float(np.sqrt(scatter / xx.sum())) if some.any() else np.inf,
        mode_level=1 + _weighted(modes.shift + own[:, None] * regressor, weight),
        level=1 + _weighted(modes.shift + common * regressor, weight),
        mode_left=mode_left,
        left=left,
        total=float(yy.sum()),
    )


def _weighted(values: FloatArray, weight: FloatArray) -> FloatArray:
    total = weight.sum(axis=1)
    return np.asarray((weight * values).sum(axis=1) / np.where(total > 0, total, 1.0))


def _level(cause: InconsistencyCause, law: _Law | None, n_modes: int) -> FloatArray:
    if law is None:
        return np.ones(n_modes)
    return law.mode_level if cause is InconsistencyCause.SQUARED_SHAPE else law.level


def _sizes(
    cause: InconsistencyCause, law: _Law | None, modes: FittedModes
) -> tuple[tuple[float, float], tuple[FloatArray, FloatArray]]:
    """Return size and standard error, of all modes and of each, see `FrequencyInconsistency`."""
    unknown = np.full(len(modes.good), np.nan)
    if law is None or cause in (InconsistencyCause.UNKNOWN, InconsistencyCause.SQUARED_SHAPE):
        return (0.0, 0.0), (unknown, unknown)
    if cause is InconsistencyCause.STEADY_DRIFT:
        return (-law.slope / 2, law.error / 2), (-law.mode_slope / 2, law.mode_error / 2)
    # The next order is m phi^2 of the mass from the mode itself, and about as much from its neighbours.
    largest = np.where(modes.good, np.abs(modes.shape) ** 2, 0.0).max(axis=1, initial=0.0)
    neglected = 2 * law.slope**2 * largest
    told = np.isfinite(law.mode_slope)
    weight = np.where(told, 1 / np.hypot(law.mode_error, neglected) ** 2, 0.0)
    each = np.where(told, law.mode_slope, 0.0)
    mass = float((weight * each).sum() / weight.sum())
    scatter = float((weight * (each - mass) ** 2).sum() / max(int(told.sum()) - 1, 1))
    error = np.sqrt(max(scatter, 1.0) / weight.sum())
    shared = float((weight * neglected).sum() / weight.sum())  # of one sign in all modes: no mean lessens it
    return (mass, float(np.hypot(error, shared))), (
        law.mode_slope,
        np.hypot(law.mode_error, neglected),
    )

"""How much the resonances of a measurement differ from the model's, in frequency and in damping."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.result import ModeShift

REACH = 3.0  # half-power bandwidths to either side of a resonance that tell of it
FEWEST = 4  # lines to either side, where bandwidths are narrower
SURE = 3e-4  # relative error of an FRF below which one mode and a straight line are not all of it either
ROUNDS = 4  # of least squares, each weighed by the pole that the last one found
APART = 0.05  # of a pole from where its resonance is: farther off it is of nothing that is there
UNKNOWN = np.nan


def mode_shifts(
    predictor: Predictor, h: ComplexArray, modes: Sequence[int], rough: Sequence[float]
) -> tuple[ModeShift, ...]:
    """Return the shifts of some modes with their standard errors.

    Near a resonance the FRF of each response is one mode and a straight line, in omega^2. Its pole is found
    by least squares in what is measured and, at as many lines with the same errors, in what is predicted:
    what window and loading do to one they do to the other. The shift is the ratio of the two poles,
    averaged over the responses by how well each shows it. Sanathanan and Koerner (1963), IEEE Trans.
    Automatic Control 8, 56-58.

    Parameters
    ----------
    h
        (n_freq, n_out) the prediction.
    modes
        Elastic modes of the model, from 1.
    rough
        The shift of each, as far as it is known.
    """
    basis = predictor.modes()
    found = []
    for mode, start in zip(modes, rough, strict=True):
        frequency, loss = float(basis.frequencies[mode - 1]), float(basis.loss_factors[mode - 1])
        before = _poles(predictor.observed, h, frequency, loss)
        after = _poles(predictor.observed, predictor.observed.h, frequency * (1 + start), loss)
        found.append(ModeShift(mode, frequency, *_ratio(before, after)))
    return tuple(found)


def _ratio(
    before: tuple[ComplexArray, FloatArray], after: tuple[ComplexArray, FloatArray]
) -> tuple[float, float, float, float]:
    """Return the mean shifts of frequency and loss factor of poles and their standard errors."""
    (p, wrong), (q, error) = before, after
    seen = np.isfinite(wrong) & np.isfinite(error) & (p.real > 0) & (q.real > 0)
    if not seen.any():
        return UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN
    p, q, spread = p[seen], q[seen], np.hypot(wrong[seen], error[seen])
    shift, shift_error = _mean(np.sqrt(q.real / p.real) - 1, spread / 2)
    loss = p.imag / p.real
    if not (loss > 0).all():
        return shift, shift_error, UNKNOWN, UNKNOWN
    return shift, shift_error, *_mean(q.imag / q.real / loss - 1, spread / loss)


def _mean(values: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Return the weighted mean and its error, by what is stated or by how values scatter, if that is more."""
    weight = 1 / errors**2
    mean = float((weight * values).sum() / weight.sum())
    off = float((weight * (values - mean) ** 2).sum()) / max(len(values) - 1, 1)
    return mean, float(np.sqrt(max(1.0, off) / weight.sum()))


def _poles(
    observed: Observed, h: ComplexArray, frequency: float, loss: float
) -> tuple[ComplexArray, FloatArray]:
    """Return poles omega_r^2 (1 + i eta), (rad/s)^2, near a frequency and their relative errors, (n_out,).

    nan where a response does not show one.
    """
    spacing = float(observed.freq[1] - observed.freq[0])
    near = np.abs(observed.freq - frequency) < max(REACH * loss * frequency, FEWEST * spacing)
    x = (observed.freq[near] / frequency) ** 2
    values, error = h[near].T, np.hypot(observed.error[near], SURE).T
    usable = observed.usable[near].T
    n_out = len(values)
    nothing = np.full(n_out, UNKNOWN)
    if len(x) < 2 * FEWEST - 1:
        return nothing.astype(complex), nothing
    size = np.where(usable, np.abs(values), 1.0)
    pole = np.full(n_out, 1 + 1j * max(loss, 1e-6), complex)
    # h (p - x) = n_0 + n_1 x, over the error of its left side.
    straight = np.broadcast_to(np.stack([-np.ones_like(x), -x], axis=1), (n_out, len(x), 2))
    rows = np.concatenate([values[..., None], straight], axis=2)
    for _ in range(ROUNDS):
        weight = np.where(usable, 1 / (error * size * np.abs(pole[:, None] - x)), 0.0)
        inverse = np.linalg.pinv(rows * weight[..., None])
        best = inverse @ (weight * values * x)[..., None]
        pole = best[:, 0, 0]
    left = weight * (values * x - (rows @ best)[..., 0])
    spare = usable.sum(axis=1) - 3
    # `error` is that of a complex number's real part: half of what the square of its size has.
    scale = (np.abs(left) ** 2).sum(axis=1) / (2 * np.maximum(spare, 1))
    spread = np.sqrt(np.maximum(scale, 1.0) * (np.abs(inverse[:, 0]) ** 2).sum(axis=1))
    seen = (spare > 0) & (np.abs(pole - 1) < APART) & (spread > 0) & (spread < APART)
    unit = (2 * np.pi * frequency) ** 2
    return np.where(seen, pole * unit, UNKNOWN), np.where(seen, spread, UNKNOWN)

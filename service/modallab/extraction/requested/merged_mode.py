"""One mode in place of several: means weighted by inverse variance."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.modal_model import Mode, Spread
from modallab.extraction.summary import FlagKind, flag_kind

NEIGHBOUR_KINDS = (FlagKind.PAIR, FlagKind.COINCIDENT, FlagKind.DOUBLED)  # flags that name another mode


def merged_mode(modes: Sequence[Mode]) -> Mode:
    """Return one mode in place of several.

    Frequency, loss factor and shape are means weighted by inverse variance, unweighted where a mode has no
    standard error. Standard errors are widened by the scatter of the modes where that exceeds them.

    Parameters
    ----------
    modes
        At least two modes at the same DoFs; their shapes may differ in sense, or in scale if unscaled.
    """
    means = {
        name: _mean(
            [getattr(mode, name) for mode in modes], [mode.standard_errors.get(name) for mode in modes]
        )
        for name in ("frequency", "loss_factor")
    }
    errors = {name: error for name, (_, error) in means.items() if error is not None}
    shape, shape_errors = _shape(modes)
    frequencies = " and ".join(f"{mode.frequency:.6g}" for mode in modes)
    return Mode(
        frequency=means["frequency"][0],
        loss_factor=means["loss_factor"][0],
        shape=shape,
        frequency_spread=_spread([mode.frequency_spread for mode in modes]),
        loss_factor_spread=_spread([mode.loss_factor_spread for mode in modes]),
        standard_errors=errors,
        shape_errors=shape_errors,
        leakage_bias={
            name: max(mode.leakage_bias.get(name, 0.0) for mode in modes) for name in modes[0].leakage_bias
        },
        flags=(f"merged: from {frequencies} Hz", *_flags(modes)),
    )


def _flags(modes: Sequence[Mode]) -> list[str]:
    flags = dict.fromkeys(flag for mode in modes for flag in mode.flags)
    return [flag for flag in flags if flag_kind(flag) not in NEIGHBOUR_KINDS]


def _mean(values: Sequence[float], errors: Sequence[float | None]) -> tuple[float, float | None]:
    known = [error for error in errors if error is not None and np.isfinite(error) and error > 0]
    if len(known) < len(values):
        return float(np.mean(values)), None
    weight, value = 1 / np.array(known) ** 2, np.array(values)
    mean = float((weight * value).sum() / weight.sum())
    scatter = float(np.sqrt((weight * (value - mean) ** 2).sum() / (len(value) - 1)))
    return mean, max(scatter, 1.0) / float(np.sqrt(weight.sum()))


def _shape(modes: Sequence[Mode]) -> tuple[ComplexArray, FloatArray | None]:
    """Return the mean of shapes in one sense, and its standard errors."""
    reference = modes[0].shape
    shapes = np.stack([mode.shape * _sense(mode.shape, reference) for mode in modes])
    known = [mode.shape_errors for mode in modes if mode.shape_errors is not None]
    errors = np.stack(known) if len(known) == len(modes) else np.zeros((1, 1))
    if not (errors > 0).all():
        return shapes.mean(axis=0), None
    weight = 1 / errors**2
    return (weight * shapes).sum(axis=0) / weight.sum(axis=0), 1 / np.sqrt(weight.sum(axis=0))


def _sense(shape: ComplexArray, reference: ComplexArray) -> float:
    return -1.0 if np.vdot(reference, shape).real < 0 else 1.0


def _spread(spreads: Sequence[Spread | None]) -> Spread | None:
    """Return the spread of all values together."""
    known = [spread for spread in spreads if spread is not None]
    if len(known) < len(spreads):
        return None
    n = sum(spread.n for spread in known)
    mean = sum(spread.n * spread.mean for spread in known) / n
    squares = sum((s.n - 1) * s.sd**2 + s.n * (s.mean - mean) ** 2 for s in known)
    return Spread(
        min(spread.min for spread in known),
        max(spread.max for spread in known),
        mean,
        float(np.sqrt(squares / max(n - 1, 1))),
        n,
    )

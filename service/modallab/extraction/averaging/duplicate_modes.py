"""Modes of a global method that are one mode, which moves from FRF to FRF by a known law."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.frequency_inconsistency import InconsistencyCause
from modallab.core.modal_model import ModalModel

FOLLOWS = 0.1  # of the sum of its squared shifts: a mode that leaves more to the law may be two
DOUBTS = ("outlier: ", "complex shape: ", "misfit: ")  # flags of what may be more than one mode
CAUSES = {
    InconsistencyCause.ROVING_MASS: "as {:.3g} g that move with the response make it",
    InconsistencyCause.STEADY_DRIFT: "as a drift by {:.3g} % makes it",
}
IN_WORDS = {InconsistencyCause.ROVING_MASS: 1e3, InconsistencyCause.STEADY_DRIFT: 100.0}


def with_duplicate_flags(model: ModalModel, alone: ModalModel | None) -> ModalModel:
    """Return the modes with a flag on those that several of share one mode of the structure.

    Where FRFs are of several structures two common poles or more mimic one that wanders. A pair of modes does
    not look so: frequencies fitted to it FRF by FRF go as its two shapes have it, and do not fall with the
    square of one, by the same mass as those of all other modes. What follows no law is left as it is.

    Parameters
    ----------
    model
        From a global method.
    alone
        Modes found FRF by FRF; None where none were.
    """
    if alone is None or alone.wander is None or alone.wander.cause not in CAUSES:
        return model
    cause, size = alone.wander.cause, alone.wander.size
    flags = [mode.flags for mode in model.modes]
    for m in np.flatnonzero(_lawful(alone)).tolist():
        frequency = alone.modes[m].frequency + alone.wander.shift[m]
        lowest, highest = float(np.nanmin(frequency)), float(np.nanmax(frequency))
        within = np.flatnonzero((model.frequencies >= lowest) & (model.frequencies <= highest))
        for one in within.tolist() if len(within) > 1 else []:
            others = ", ".join(f"{model.frequencies[other]:.5g} Hz" for other in within if other != one)
            flags[one] = (
                *flags[one],
                f"doubled: one mode with {others}, which FRF by FRF lies between {lowest:.5g} and "
                f"{highest:.5g} Hz, {CAUSES[cause].format(IN_WORDS[cause] * size)}",
            )
    return replace(
        model, modes=tuple(replace(mode, flags=own) for mode, own in zip(model.modes, flags, strict=True))
    )


def _lawful(alone: ModalModel) -> BoolArray:
    """Return which modes, each clearly one, move as the law of all of them has it, (n_modes,)."""
    wander = alone.wander
    assert wander is not None
    left = wander.shift - _expected(alone)
    left = left - np.nanmean(left, axis=1, keepdims=True)
    clear = [not any(flag.startswith(DOUBTS) for flag in mode.flags) for mode in alone.modes]
    return np.asarray(clear & (np.nansum(left**2, axis=1) < FOLLOWS * np.nansum(wander.shift**2, axis=1)))


def _expected(alone: ModalModel) -> FloatArray:
    """Return how far the law moves each mode in each FRF, (n_modes, n_frf) Hz, to first order."""
    wander = alone.wander
    assert wander is not None
    if wander.cause is InconsistencyCause.STEADY_DRIFT:
        along = np.linspace(0.0, 1.0, wander.shift.shape[1])[None]
        return np.asarray(alone.frequencies[:, None] * wander.size * along)
    square = (alone.shapes.T**2).real.repeat(len(alone.references), axis=1)
    return np.asarray(-alone.frequencies[:, None] * wander.size * square / 2)

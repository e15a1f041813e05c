"""Flags on modes of a global method that are one mode of inconsistent frequency."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.frequency_inconsistency import InconsistencyCause
from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.settings import DUPLICATE_MODES

AMBIGUOUS_FLAGS = ("outlier: ", "complex shape: ", "misfit: ")  # flags of what may be more than one mode
CAUSES = {
    InconsistencyCause.ROVING_MASS: "as with {:.3g} g of roving mass",
    InconsistencyCause.STEADY_DRIFT: "as with a drift of {:.3g} %",
}
UNITS_IN_TEXT = {InconsistencyCause.ROVING_MASS: 1e3, InconsistencyCause.STEADY_DRIFT: 100.0}


def with_duplicate_flags(model: ModalModel, single_modes: ModalModel | None) -> ModalModel:
    """Return the modes, with a flag where several of them represent one mode of the structure.

    If FRFs belong to slightly different structures, two or more common poles imitate one mode whose frequency
    varies. A genuine pair of modes differs from that: frequencies fitted to it FRF by FRF follow its two
    shapes, and do not fall with the square of one shape by the same mass as those of all other modes. Shifts
    without an identified cause are left unflagged.

    Parameters
    ----------
    model
        From a global method.
    single_modes
        Modes identified FRF by FRF; None if there are none.
    """
    if (
        single_modes is None
        or single_modes.frequency_inconsistency is None
        or single_modes.frequency_inconsistency.cause not in CAUSES
    ):
        return model
    cause, size = single_modes.frequency_inconsistency.cause, single_modes.frequency_inconsistency.size
    flags = [mode.flags for mode in model.modes]
    for lowest, highest in _explained_ranges(single_modes):
        within = np.flatnonzero((model.frequencies >= lowest) & (model.frequencies <= highest))
        for row in within.tolist() if len(within) > 1 else []:
            duplicates = ", ".join(
                f"{model.frequencies[duplicate]:.5g} Hz" for duplicate in within if duplicate != row
            )
            flags[row] = (
                *flags[row],
                f"doubled: the same mode as {duplicates}; its frequency varies over the FRFs from "
                f"{lowest:.5g} to {highest:.5g} Hz, {CAUSES[cause].format(UNITS_IN_TEXT[cause] * size)}",
            )
    return replace(
        model,
        modes=tuple(
            replace(mode, flags=mode_flags) for mode, mode_flags in zip(model.modes, flags, strict=True)
        ),
    )


def drift_ranges(single_modes: ModalModel | None) -> tuple[tuple[float, float], ...]:
    """Return lowest and highest frequency, Hz, of each unambiguous mode that a steady drift moves.

    Parameters
    ----------
    single_modes
        Modes identified FRF by FRF; None if there are none.
    """
    inconsistency = None if single_modes is None else single_modes.frequency_inconsistency
    if (
        single_modes is None
        or inconsistency is None
        or inconsistency.cause is not InconsistencyCause.STEADY_DRIFT
    ):
        return ()
    return tuple(_explained_ranges(single_modes))


def _explained_ranges(single_modes: ModalModel) -> Iterator[tuple[float, float]]:
    """Yield lowest and highest frequency, Hz, of each mode that shifts as the common cause predicts."""
    inconsistency = single_modes.frequency_inconsistency
    assert inconsistency is not None
    for m in np.flatnonzero(_explained(single_modes)).tolist():
        frequency = single_modes.modes[m].frequency + inconsistency.shift[m]
        yield float(np.nanmin(frequency)), float(np.nanmax(frequency))


def _explained(single_modes: ModalModel) -> BoolArray:
    """Return which unambiguous modes shift as the common cause predicts, (n_modes,) boolean."""
    inconsistency = single_modes.frequency_inconsistency
    assert inconsistency is not None
    remainder = inconsistency.shift - _expected(single_modes)
    remainder = remainder - np.nanmean(remainder, axis=1, keepdims=True)
    clear = [not any(flag.startswith(AMBIGUOUS_FLAGS) for flag in mode.flags) for mode in single_modes.modes]
    return np.asarray(
        clear
        & (
            np.nansum(remainder**2, axis=1)
            < DUPLICATE_MODES.unexplained_fraction * np.nansum(inconsistency.shift**2, axis=1)
        )
    )


def _expected(single_modes: ModalModel) -> FloatArray:
    """Return the first-order shift of each mode in each FRF by the cause, (n_modes, n_frf) Hz."""
    inconsistency = single_modes.frequency_inconsistency
    assert inconsistency is not None
    if inconsistency.cause is InconsistencyCause.STEADY_DRIFT:
        along = np.linspace(0.0, 1.0, inconsistency.shift.shape[1])[None]
        return np.asarray(single_modes.frequencies[:, None] * inconsistency.size * along)
    square = (single_modes.shapes.T**2).real.repeat(len(single_modes.references), axis=1)
    return np.asarray(-single_modes.frequencies[:, None] * inconsistency.size * square / 2)

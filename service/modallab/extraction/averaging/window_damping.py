"""Correction of loss factors for the damping that an exponential window adds."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.modal_model import ModalModel, Mode, Spread


def without_window_damping(model: ModalModel, added_loss_factor: FloatArray) -> ModalModel:
    """Return the modes with `added_loss_factor` (n_modes,) subtracted from their loss factors.

    This includes the loss factor of each FRF's fit and the spread, whose standard deviation is unchanged. A
    loss factor smaller than that of the window becomes negative, within its error, and is flagged.

    Parameters
    ----------
    model
        Modes of windowed records.
    added_loss_factor
        `modallab.estimation.windows.added_loss_factor` at the modes' frequencies.
    """
    modes = tuple(
        _reduced(mode, float(eta)) for mode, eta in zip(model.modes, added_loss_factor, strict=True)
    )
    fitted = model.fitted_loss_factor
    share = ", ".join(f"{eta:.3g}" for eta in added_loss_factor)
    return replace(
        model,
        modes=modes,
        fitted_loss_factor=None if fitted is None else fitted - np.asarray(added_loss_factor)[:, None],
        notes=(*model.notes, f"loss factors added by the exponential window were subtracted: {share}"),
    )


def _reduced(mode: Mode, eta: float) -> Mode:
    spread = mode.loss_factor_spread
    flags = mode.flags if mode.loss_factor > eta else (*mode.flags, "window_damping")
    return replace(
        mode,
        loss_factor=mode.loss_factor - eta,
        loss_factor_spread=None if spread is None else _shifted(spread, -eta),
        flags=flags,
    )


def _shifted(spread: Spread, by: float) -> Spread:
    return replace(spread, min=spread.min + by, max=spread.max + by, mean=spread.mean + by)

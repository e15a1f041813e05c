"""Taking the damping that an exponential window adds out of modes."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.modal_model import ModalModel, Mode, Spread


def without_added(model: ModalModel, added: FloatArray) -> ModalModel:
    """Return the modes with `added` (n_modes,) taken out of their loss factors.

    The loss factor of every mode and of each FRF's fit, and where these lie; their scatter stays. A
    loss factor smaller than what the window added comes out negative, within its error: it says so.

    Parameters
    ----------
    added
        `modallab.estimation.windows.added_loss_factor` at the modes' frequencies.
    """
    modes = tuple(_less(mode, float(eta)) for mode, eta in zip(model.modes, added, strict=True))
    fitted = model.fitted_loss_factor
    share = ", ".join(f"{eta:.3g}" for eta in added)
    return replace(
        model,
        modes=modes,
        fitted_loss_factor=None if fitted is None else fitted - np.asarray(added)[:, None],
        notes=(*model.notes, f"loss factors are without those that the exponential window added: {share}"),
    )


def _less(mode: Mode, eta: float) -> Mode:
    spread = mode.loss_factor_spread
    flags = mode.flags if mode.loss_factor > eta else (*mode.flags, "window_damping")
    return replace(
        mode,
        loss_factor=mode.loss_factor - eta,
        loss_factor_spread=None if spread is None else _moved(spread, -eta),
        flags=flags,
    )


def _moved(spread: Spread, by: float) -> Spread:
    return replace(spread, min=spread.min + by, max=spread.max + by, mean=spread.mean + by)

"""Which law of damping the lines tell, by how modal constants are turned."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.modal_model import ModalModel
from modallab.extraction.options import Damping

LEAST_MODES = 3  # of fewer, a phase that gauges turn is not told from one that the law turns
SURE = 5.0  # standard errors from what the other law would make
AGREES = 3.0  # standard errors, or this part where errors are less, from what the law makes
PART = 0.25
SPOILT = ("misfit", "further peak", "leakage_bias", "references differ", "pair", "coincident")


@dataclass(frozen=True)
class DampingModelChoice:
    """What the phases of modal constants tell."""

    law: Damping | None  # None where they do not tell
    turn: float  # of the constants, over what viscous damping would make it: 0 structural, 1 viscous
    error: float

    @property
    def said(self) -> str:
        """The law to take and why, as `choices` have it."""
        if self.law is None:
            return f"{Damping.STRUCTURAL}: unless another is asked for; the lines do not tell which law holds"
        turned = f"{self.turn:.2g} +- {self.error:.1g} of what viscous damping would turn them by"
        return f"{self.law}: as the lines tell, whose modal constants are turned by {turned}"


def select_damping_model(model: ModalModel) -> DampingModelChoice:
    """Return the law that modes fitted as structural ones are told to have.

    A viscous mode, `A/(omega_r^2 - omega^2 + 2 i zeta omega_r omega)`, has its pole at `omega^2 = -s^2`, with
    `A s/(i omega_d)` over it, so that real A are found turned by zeta nearly, half the loss factor: all FRFs
    alike, and every mode by its own. The turn of all modes over this one is 0 under structural
    damping and 1 under viscous. What else turns constants, gauges or shapes that are complex, does not go
    as loss factors do: how modes scatter about one turn widens its error. Modes that a flag says are spoilt
    do not count.
    """
    rows = [m for m, mode in enumerate(model.modes) if not any(f.startswith(SPOILT) for f in mode.flags)]
    if len(rows) < LEAST_MODES or model.modal_constant is None or model.modal_constant_error is None:
        return DampingModelChoice(None, np.nan, np.inf)
    half, phase, error = _phases(model, rows)
    weight = (half / error) ** 2
    turn = float((weight * phase / half).sum() / weight.sum())
    scatter = float((((phase - turn * half) / error) ** 2).sum()) / (len(rows) - 1)
    wide = float(np.sqrt(max(scatter, 1.0) / weight.sum()))
    for law, made in ((Damping.STRUCTURAL, 0.0), (Damping.VISCOUS, 1.0)):
        near = abs(turn - made) < max(AGREES * wide, PART)
        if near and abs(turn - (1.0 - made)) > SURE * wide:
            return DampingModelChoice(law, turn, wide)
    return DampingModelChoice(None, turn, wide)


def _phases(model: ModalModel, rows: list[int]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return half the loss factors, and the phases of the constants with their errors, rad, (n_modes,)."""
    constant, error = np.asarray(model.modal_constant)[rows], np.asarray(model.modal_constant_error)[rows]
    weight = 1 / np.maximum(error, 1e-9 * np.abs(constant).max()) ** 2
    power = (weight * np.abs(constant) ** 2).sum(axis=1)
    # of either sign: by their squares
    phase = np.angle((weight * constant**2).sum(axis=1)) / 2
    return model.loss_factors[rows] / 2, phase, 1 / np.sqrt(power)


def with_damping_model(model: ModalModel, told: DampingModelChoice) -> ModalModel:
    """Return the model with its law said to be chosen, and where it was told without flags about it."""
    model = replace(model, choices={**model.choices, "damping": told.said})
    if told.law is None:
        return model
    modes = (
        replace(mode, flags=tuple(flag for flag in mode.flags if not flag.startswith("damping_law")))
        for mode in model.modes
    )
    return replace(model, modes=tuple(modes))

"""Choice of the damping model from the phases of modal constants."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.modal_model import ModalModel
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.extraction.averaging.settings import DAMPING_MODEL
from modallab.extraction.options import Damping

DISQUALIFYING_FLAGS = ("misfit", "further peak", "leakage_bias", "references differ", "pair", "coincident")


@dataclass(frozen=True)
class DampingModelChoice:
    """Damping model that the phases of modal constants indicate."""

    damping: Damping | None
    """None where the phases do not decide."""
    phase_ratio: float
    """Phase of the constants over that of viscous modes: 0 structural, 1 viscous."""
    error: float
    """Standard error of the ratio."""

    @property
    def reason(self) -> str:
        """Damping model and reason, as in the `choices` of a modal model."""
        if self.damping is None:
            return f"{Damping.STRUCTURAL}: the default, because the lines do not determine the damping model"
        ratio = f"{self.phase_ratio:.2g} +- {self.error:.1g} of the phase under viscous damping"
        return f"{self.damping}: determined from the lines, where modal constants have {ratio}"


def select_damping_model(model: ModalModel, fitted: Damping = Damping.STRUCTURAL) -> DampingModelChoice:
    """Return the damping model that modes indicate which were fitted with the damping model `fitted`.

    A viscous mode `A/(omega_r^2 - omega^2 + 2 i zeta omega_r omega)` has a pole at `omega^2 = -s^2` with
    residue `A s/(i omega_d)`: a real A appears with a phase of nearly zeta, half the loss factor, the same in
    all FRFs and specific to each mode. The phase over half the loss factor, averaged over all modes, is 0
    under structural and 1 under viscous damping. Other sources of phase, transducers or complex shapes, are
    not proportional to loss factors: the scatter of the modes increases the standard error. Modes with
    disqualifying flags are not used. In a viscous fit all phases are less by half the loss factor.
    """
    rows = [
        m
        for m, mode in enumerate(model.modes)
        if not any(f.startswith(DISQUALIFYING_FLAGS) for f in mode.flags)
    ]
    if (
        len(rows) < DAMPING_MODEL.minimum_modes
        or model.modal_constant is None
        or model.modal_constant_error is None
    ):
        return DampingModelChoice(None, np.nan, np.inf)
    half, phase, error = _phases(model, rows)
    if fitted is Damping.VISCOUS:
        phase = phase + half
    weight = (half / error) ** 2
    phase_ratio = float((weight * phase / half).sum() / weight.sum())
    scatter = float((((phase - phase_ratio * half) / error) ** 2).sum()) / (len(rows) - 1)
    phase_error = float(np.sqrt(max(scatter, 1.0) / weight.sum()))
    for law, expected_phase in ((Damping.STRUCTURAL, 0.0), (Damping.VISCOUS, 1.0)):
        near = abs(phase_ratio - expected_phase) < max(
            DAMPING_MODEL.agreement_errors * phase_error, DAMPING_MODEL.agreement_fraction
        )
        if near and abs(phase_ratio - (1.0 - expected_phase)) > DAMPING_MODEL.rejection_errors * phase_error:
            return DampingModelChoice(law, phase_ratio, phase_error)
    return DampingModelChoice(None, phase_ratio, phase_error)


def _phases(model: ModalModel, rows: list[int]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return half the loss factors, and the phases of the constants with errors, rad, each (n_modes,)."""
    constant, error = np.asarray(model.modal_constant)[rows], np.asarray(model.modal_constant_error)[rows]
    weight = 1 / np.maximum(error, COMPARISON_ROUNDING * np.abs(constant).max()) ** 2
    power = (weight * np.abs(constant) ** 2).sum(axis=1)
    # squares, because constants of a mode have both signs
    phase = np.angle((weight * constant**2).sum(axis=1)) / 2
    return model.loss_factors[rows] / 2, phase, 1 / np.sqrt(power)


def with_contradiction_flags(model: ModalModel, fitted: Damping) -> ModalModel:
    """Return the modes, flagged if their phases contradict the damping model that they were fitted with.

    Errors of such modes are systematic, and their standard errors do not contain them.
    """
    choice = select_damping_model(model, fitted)
    if choice.damping is None or choice.damping is fitted:
        return model
    flag = (
        f"damping_law: the lines show {choice.damping} damping, not {fitted}: errors exceed standard errors"
    )
    modes = (replace(mode, flags=(*mode.flags, flag)) for mode in model.modes)
    return replace(model, modes=tuple(modes))


def with_damping_model(model: ModalModel, choice: DampingModelChoice) -> ModalModel:
    """Return the model with the choice of its damping model, without flags on it if it was decided."""
    model = replace(model, choices={**model.choices, "damping": choice.reason})
    if choice.damping is None:
        return model
    modes = (
        replace(mode, flags=tuple(flag for flag in mode.flags if not flag.startswith("damping_law")))
        for mode in model.modes
    )
    return replace(model, modes=tuple(modes))

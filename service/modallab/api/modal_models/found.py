"""What a reply shows of a modal model."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, Field

from modallab.api.thinning import numbers
from modallab.api.wire import EntryOut
from modallab.core.arrays import FloatArray
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.core.modal_model import ModalModel, Mode
from modallab.correlation.complexity import mean_phase, mean_phase_deviation, phase_collinearity
from modallab.store.base import Entry

MOST_SHIFTS = 2_000  # numbers of a wander's table in JSON; beyond, `/arrays` has them
_UNITS = {InconsistencyCause.ROVING_MASS: "kg"}


class WanderOut(BaseModel):
    """Frequencies that differ between FRFs by more than their random error.

    `size` is the kg that move with the response, or the relative change of frequency from the first FRF to
    the last, or 0; shifts are from the plain mean of each mode, by FRF, one a mode, null where an FRF
    does not show it. Where there are very many, `/arrays` alone has them: `wander_shift`.
    """

    cause: str
    size: float | None
    size_error: float | None
    unit: str
    explained: float | None = Field(description="0 to 1: the part of the scatter that goes with the cause")
    shift: dict[str, list[float | None]] | None = Field(description="Hz")
    shift_error: dict[str, list[float | None]] | None = Field(description="Hz, standard errors")
    still_frequency: list[float | None] = Field(
        description="Hz: without the roving mass, before the drift, or the mean"
    )
    mode_size: list[float | None] = Field(description="the size from each mode alone")
    mode_size_error: list[float | None]

    @classmethod
    def of(cls, wander: FrequencyInconsistency, frfs: Sequence[str]) -> Self:
        """Return what the contract shows of a wander."""
        few = wander.shift.size <= MOST_SHIFTS
        return cls(
            cause=wander.cause.value,
            size=_finite(wander.size),
            size_error=_finite(wander.size_error),
            unit=_UNITS.get(wander.cause, "1"),
            explained=_finite(wander.explained),
            shift=_by_frf(frfs, wander.shift) if few else None,
            shift_error=_by_frf(frfs, wander.shift_error) if few else None,
            still_frequency=numbers(wander.still_frequency),
            mode_size=numbers(wander.mode_size),
            mode_size_error=numbers(wander.mode_size_error),
        )


class ComplexityOut(BaseModel):
    """How far the points of a mode do not move in step."""

    mpc: float = Field(description="modal phase collinearity: 1 where they do")
    mean_phase: float = Field(description="rad, -pi/2 to pi/2")
    mean_phase_deviation: float = Field(description="rad, from 0")


class ModalModelOut(EntryOut):
    """Modes without their shapes, which `/arrays` gives."""

    method: str
    measurement_id: str | None
    normalisation: str
    drive: str | None = Field(description="the point that all FRFs share; null where there are several")
    references: list[str] = Field(
        description="points that FRFs share: drive points, or responses while a hammer roves"
    )
    frfs: list[str] = Field(
        description="names of the FRFs, in the order of the arrays: a DoF, of several references each with "
        "each DoF, `5:+Y / 1:+Y`"
    )
    dofs: list[str]
    modes: list[dict[str, Any]]
    choices: dict[str, str] = Field(description="option -> what was taken, and why")
    resynthesis_error: dict[str, float] | None = Field(
        description="by FRF: rms of what modes and residuals leave over rms of the FRF, as mobility"
    )
    wander: WanderOut | None
    notes: list[str]

    @classmethod
    def of(cls, model: ModalModel, entry: Entry) -> Self:
        """Return what the contract shows of a modal model."""
        dofs = [str(dof) for dof in model.dofs]
        left = model.resynthesis_error
        shapes = zip(model.modes, _complexity(model), strict=True)
        return cls(
            **cls.fields(entry),
            method=model.method,
            measurement_id=entry.inputs.get("measurement_id"),
            normalisation=model.normalisation,
            drive=None if model.drive is None else str(model.drive),
            references=[str(dof) for dof in model.references],
            frfs=list(model.frfs) if model.references else [],
            dofs=dofs,
            modes=[_mode_out(mode) | {"complexity": complexity} for mode, complexity in shapes],
            choices=dict(model.choices),
            resynthesis_error=None if left is None else dict(zip(model.frfs, left.tolist(), strict=True)),
            wander=None if model.wander is None else WanderOut.of(model.wander, model.frfs),
            notes=list(model.notes),
        )


def _complexity(model: ModalModel) -> list[ComplexityOut]:
    if not model.modes:
        return []
    columns = (of(model.shapes) for of in (phase_collinearity, mean_phase, mean_phase_deviation))
    return [
        ComplexityOut(mpc=mpc, mean_phase=phase, mean_phase_deviation=deviation)
        for mpc, phase, deviation in zip(*(column.tolist() for column in columns), strict=True)
    ]


def _mode_out(mode: Mode) -> dict[str, Any]:
    return {
        "frequency": mode.frequency,
        "loss_factor": mode.loss_factor,
        "frequency_spread": mode.frequency_spread and asdict(mode.frequency_spread),
        "loss_factor_spread": mode.loss_factor_spread and asdict(mode.loss_factor_spread),
        "standard_errors": dict(mode.standard_errors),
        "flags": list(mode.flags),
    }


def _by_frf(frfs: Sequence[str], table: FloatArray) -> dict[str, list[float | None]]:
    """Return a table (n_modes, n_frf) by FRF."""
    return dict(zip(frfs, numbers(table.T), strict=True))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None

"""Wire types of updates on frequency responses, and what is asked of a measurement for one."""

from typing import Self

from pydantic import BaseModel

from modallab.fe.structure import Structure
from modallab.jobs.updating import measured_responses
from modallab.rig.measurement import Measurement
from modallab.updating.responses.result import ResponseFit


class ResponsesOut(BaseModel):
    """How well the model's FRFs are the measured ones: mean squares of log ratios over their random error.

    1 if only random errors are left; `scatter` is the standard deviation of such a mean by these alone.
    `held_out`: the same of lines that were not used to find the coefficients. `by_frf`: outputs x inputs.
    """

    before: float
    after: float
    scatter: float
    n_lines: int
    band: tuple[float, float]
    n_held_out: int
    held_out_before: float | None
    held_out_after: float | None
    outputs: list[str]
    inputs: list[str]
    by_frf_before: list[list[float]]
    by_frf_after: list[list[float]]

    @classmethod
    def of(cls, fit: ResponseFit) -> Self:
        """Return what the contract shows of how well responses fit."""
        plain = {name: getattr(fit, name) for name in ("before", "after", "scatter", "n_held_out")}
        plain |= {name: getattr(fit, name) for name in ("held_out_before", "held_out_after")}
        return cls(
            **plain,
            n_lines=len(fit.freq),
            band=(float(fit.freq[0]), float(fit.freq[-1])),
            outputs=[str(dof) for dof in fit.outputs],
            inputs=[str(dof) for dof in fit.inputs],
            by_frf_before=fit.by_frf_before.tolist(),
            by_frf_after=fit.by_frf_after.tolist(),
        )


def check_responses(structure: Structure, measurement: Measurement, noise_floor: float | None) -> None:
    """Raise unless a model may be held against the FRFs of a measurement.

    Raises
    ------
    InvalidInputError
        If neither coherence nor a noise floor tells their random errors.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    target = measured_responses(measurement, noise_floor)
    for dof in (*target.outputs, *target.inputs):
        structure.index(dof)

"""Requirements of updates on frequency responses."""

from modallab.core.line_options import LineOptions
from modallab.fe.structure import Structure
from modallab.jobs.updating import measured_responses
from modallab.rig.measurement import Measurement


def check_responses(
    structure: Structure, measurement: Measurement, noise_floor: float | None, lines: LineOptions
) -> None:
    """Raise unless the FRFs of a model can be compared with those of a measurement.

    Raises
    ------
    InvalidInputError
        If neither coherence nor a noise floor gives their random errors, or a band has no lines.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    target = measured_responses(measurement, noise_floor, lines)
    for dof in (*target.outputs, *target.inputs):
        structure.index(dof)

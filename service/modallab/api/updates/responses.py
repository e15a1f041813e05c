"""Requirements of updates on frequency responses."""

from modallab.fe.structure import Structure
from modallab.jobs.updating import measured_responses
from modallab.rig.measurement import Measurement


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

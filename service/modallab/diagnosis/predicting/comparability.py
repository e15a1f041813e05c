"""Check that model and log book can predict a measurement."""

from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement


def check_comparable(structure: Structure, measurement: Measurement) -> None:
    """Raise unless the model and the log book can predict the measurement.

    Raises
    ------
    InvalidInputError
        If several shakers act at once, if a line is none of the log book's, or if these are no multiples of
        their spacing.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    for dof in (*measurement.setup.drives, *measurement.frf.outputs):
        structure.index(dof)
    if any(len(run.drives) > 1 for run in measurement.setup.acquisition_runs):
        raise InvalidInputError(
            "a diagnosis takes one force at a time: random errors of FRFs to simultaneous shakers are "
            "correlated; measure with one shaker after the other, or with a roving hammer",
            field="inputs",
            value=list(map(str, measurement.frf.inputs)),
            allowed="one shaker, or a hammer at one drive point after the other",
        )
    measurement.setup.analyser.baseband.lines_at(measurement.frf.freq)

"""Check that model and log book can predict a measurement."""

from modallab.fe.structure import Structure
from modallab.rig.compatibility import check_compatible
from modallab.rig.measurement import Measurement


def check_comparable(structure: Structure, measurement: Measurement) -> None:
    """Raise unless the model and the log book can predict the measurement.

    Raises
    ------
    InvalidInputError
        If several shakers have the same signal, if a line is none of the log book's, or if these are no
        multiples of their spacing.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    for dof in (*measurement.setup.drives, *measurement.frf.outputs):
        structure.index(dof)
    if measurement.setup.n_simultaneous > 1:
        check_compatible(measurement.setup)
    measurement.setup.analyser.baseband.lines_at(measurement.frf.freq)

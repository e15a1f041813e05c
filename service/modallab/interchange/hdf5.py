"""Measurements as HDF5 files: the names of the npz file, with units."""

import io

import numpy as np

from modallab.core.frf import FrfKind
from modallab.rig.measurement import Measurement

_MOTIONS = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}


def write(measurement: Measurement) -> bytes:
    """Return a measurement as an HDF5 file; the same measurement gives the same bytes.

    Datasets `freq, values, outputs, inputs, kind, averages`, and where there are such `coherence,
    force_spectrum, response_spectrum, force_cross_spectra`, shaped as in a measurement's npz file. Those of
    numbers have an attribute `unit`, and the file has the measurement's `notes` as one.
    """
    import h5py  # only files of this format need it

    frf, motion = measurement.frf, _MOTIONS[measurement.frf.kind]
    arrays = {
        "freq": (frf.freq, "Hz"),
        "values": (frf.values, f"{motion}/N"),
        "coherence": (measurement.coherence, "1"),
        "averages": (np.float64(measurement.averages), "1"),
        "force_spectrum": (measurement.force_spectrum, "N^2/Hz"),
        "response_spectrum": (measurement.response_spectrum, f"({motion})^2/Hz"),
        "force_cross_spectra": (measurement.force_cross_spectra, "N^2/Hz"),
    }
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs["format"] = "modallab measurement 1"
        if measurement.notes:
            file.attrs["notes"] = "\n".join(measurement.notes)
        for name, dofs in (("outputs", frf.outputs), ("inputs", frf.inputs)):
            file.create_dataset(name, data=np.array([str(dof) for dof in dofs], dtype=bytes))
        file.create_dataset("kind", data=np.bytes_(frf.kind.value))
        for name, (array, unit) in arrays.items():
            if array is not None:
                file.create_dataset(name, data=array).attrs["unit"] = unit
    return buffer.getvalue()

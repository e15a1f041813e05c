"""The exact poles of a roving test: each response belongs to a structure loaded at that response."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from tests.published.tables import table

_BEAM = table("beam_1992")["beam"]
_N_MODES = 8
DOFS = tuple(Dof(node, "Y") for node in _BEAM["response_nodes"])


def hidden_beam() -> Structure:
    """Return the beam with the errors that the model does not know."""
    return change(
        STRUCTURES["chapter-5-beam"](),
        [
            MemberChange(tuple(_BEAM["density_doubled"]), MemberProperty.DENSITY, factor=2.0),
            MemberChange(tuple(_BEAM["stiffness_doubled"]), MemberProperty.MODULUS, factor=2.0),
        ],
    )


def _measure() -> tuple[FloatArray, FloatArray, FloatArray]:
    bare = assemble(hidden_beam()).add_mass(DOFS[0].node, _BEAM["force_transducer_mass"])
    frequencies, loss_factors, constants = [], [], []
    for dof in DOFS:
        loaded = bare.add_mass(dof.node, _BEAM["accelerometer_mass"])
        basis = loaded.modes().elastic(_N_MODES)
        drive, response = loaded.selection((DOFS[0], dof)).T @ basis.shapes.real
        frequencies.append(basis.frequencies)
        loss_factors.append(basis.loss_factors)
        constants.append(drive * response)
    return np.array(frequencies), np.array(loss_factors), np.array(constants)


# (n_positions, n_modes) Hz and 1, and shapes (n_positions, n_modes) with phi_j = A_1j / sqrt(A_11)
FREQUENCIES, LOSS_FACTORS, _CONSTANTS = _measure()
SHAPES: FloatArray = _CONSTANTS / np.sqrt(_CONSTANTS[0])


def loaded_modes() -> ModalModel:
    """Return the modes as collated from the roving test: mean frequencies, one response a DoF."""
    modes = tuple(
        Mode(float(frequency), 0.0, SHAPES[:, r].astype(complex))
        for r, frequency in enumerate(FREQUENCIES.mean(axis=0))
    )
    return ModalModel(modes, DOFS)

"""Structures whose errors an update is to find."""

import numpy as np

from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure, Support
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes

BEAM, BAY = STRUCTURES["chapter-5-beam"](), STRUCTURES["bay"]()
BEAM_DOFS = tuple(Dof(node, "Y") for node in range(1, 22, 2))
BAY_NODES = (1, 3, 5, 7, 8, 10, 13, 14, 16, 18, 20, 23, 26, 28, 30)
BAY_DOFS = tuple(Dof(node, direction) for node in BAY_NODES for direction in ("X", "Y"))
WRONG_BEAM = change(
    BEAM,
    [
        MemberChange((1, 2), MemberProperty.DENSITY, factor=2.0),
        MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0),
    ],
)
WRONG_BAY = change(
    BAY,
    [
        MemberChange((25, 26), MemberProperty.DENSITY, factor=1.5),
        MemberChange((12, 13, 31), MemberProperty.MODULUS, factor=2.0),
    ],
)


def long_cantilever() -> Structure:
    """Return a cantilever whose modes are not all worked out: 390 degrees of freedom."""
    return beam(
        length=1.5,
        n_elements=130,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(),
        supports=(Support(1, ("Y", "RZ")),),
    )


def modes_of(
    structure: Structure,
    count: int,
    dofs: tuple[Dof, ...],
    noise: ModeNoise | None = None,
    seed: int | None = None,
) -> ModalModel:
    """Return modes as measured, exact unless there is noise."""
    rng = np.random.default_rng(seed)
    return synthetic_modes(assemble(structure), count, dofs, noise=noise or ModeNoise(), rng=rng)

"""Updates of the thesis's beam and bay, each run once."""

from functools import cache

import numpy as np

from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import TwoStageOptions
from modallab.updating.parameterisation import parameterise
from tests.published import roving
from tests.published.tables import table

BEAM, FRAMES = table("beam_1992"), table("frames_1992")


def bay_with_errors(name: str) -> Structure:
    """Return the bay of table 2.1 or 3.1 as it is measured."""
    case = FRAMES[name]
    changes = [MemberChange(tuple(case["stiffness_doubled"]), MemberProperty.MODULUS, factor=2.0)]
    if "mass_times_1_5" in case:
        heavier = tuple(case["mass_times_1_5"])
        changes.append(MemberChange(heavier, MemberProperty.DENSITY, factor=1.5))
    return change(STRUCTURES["bay"](), changes)


def exact_modes(structure: Structure, count: int, dofs: tuple[Dof, ...]) -> ModalModel:
    return synthetic_modes(assemble(structure), count, dofs, noise=ModeNoise(), rng=np.random.default_rng(0))


@cache
def beam_from(target: str) -> UpdateResult:
    modes = roving.loaded_modes() if target == "loaded" else exact_modes(roving.hidden_beam(), 8, roving.DOFS)
    parameters = parameterise(BEAM["beam"]["macro_elements"])
    return UPDATERS["inverse_eigensensitivity"](STRUCTURES["chapter-5-beam"](), parameters, modes)


@cache
def bay() -> UpdateResult:
    case = FRAMES["table_3_1"]
    changes = [
        MemberChange(tuple(case["stiffness_doubled"]), MemberProperty.MODULUS, factor=2.0),
        MemberChange(tuple(case["mass_times_1_5"]), MemberProperty.DENSITY, factor=1.5),
    ]
    dofs = tuple(Dof(node, direction) for node in case["measured_nodes"] for direction in ("X", "Y"))
    structure = STRUCTURES["bay"]()
    target = exact_modes(change(structure, changes), 10, dofs)
    return UPDATERS["inverse_eigensensitivity"](structure, parameterise(case["macro_1"]), target)


def damped_bay(loss_factor: float) -> tuple[Structure, tuple[Dof, ...]]:
    case, damping = FRAMES["table_3_1"], FRAMES["table_6_1"]
    changes = [
        MemberChange(tuple(case["stiffness_doubled"]), MemberProperty.MODULUS, factor=2.0),
        MemberChange(tuple(case["mass_times_1_5"]), MemberProperty.DENSITY, factor=1.5),
        MemberChange(tuple(damping["damped"]), MemberProperty.LOSS_FACTOR, value=loss_factor),
    ]
    dofs = tuple(Dof(node, direction) for node in case["measured_nodes"] for direction in ("X", "Y"))
    return change(STRUCTURES["bay"](), changes), dofs


@cache
def updated_with_damping(case: int) -> UpdateResult:
    truth, dofs = damped_bay(FRAMES["table_6_1"][f"loss_factor_{case}"])
    parameters = parameterise(FRAMES["table_3_1"]["macro_1"], ("mass", "stiffness", "damping"))
    method = UPDATERS["complex_inverse_eigensensitivity"]
    # the default ends location one iteration before the five and six that are printed
    options = TwoStageOptions(location_tolerance=3e-3)
    return method(STRUCTURES["bay"](), parameters, exact_modes(truth, 10, dofs), options=options)

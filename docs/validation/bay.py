"""The bay of the thesis, as its tables have it."""

from dataclasses import replace
from functools import cache

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import ComplexTwoStageOptions, TwoStageOptions
from modallab.updating.parameterisation import parameterise
from tests.published.updates import FRAMES, damped_bay, exact_modes

BAY = STRUCTURES["bay"]()
DOFS = damped_bay(0.0)[1]
N_MODES = 10
MODES = tuple(str(number) for number in range(1, N_MODES + 1))
EARLY = "Both are of the iteration that the thesis prints, before convergence."


def number(name: str) -> str:
    return "Table " + name.removeprefix("table_").replace("_", ".")


def shape_rows(structure: Structure) -> FloatArray:
    system = assemble(structure)
    return np.asarray(system.selection(DOFS).T @ system.modes().elastic(N_MODES).shapes.real)


def frequencies(structure: Structure, count: int = N_MODES) -> FloatArray:
    return assemble(structure).modes().elastic(count).frequencies


@cache
def fifth_iteration(loss_factor: float) -> UpdateResult:
    truth, dofs = damped_bay(loss_factor)
    damped = loss_factor > 0
    parts = ("mass", "stiffness", "damping") if damped else ("mass", "stiffness")
    of_damped = ComplexTwoStageOptions(location_tolerance=3e-3)
    options = replace(of_damped if damped else TwoStageOptions(), max_iterations=5)
    method = UPDATERS["complex_inverse_eigensensitivity" if damped else "inverse_eigensensitivity"]
    macros = parameterise(FRAMES["table_3_1"]["macro_1"], parts)
    return method(BAY, macros, exact_modes(truth, N_MODES, dofs), options=options)

"""Responses of frames that updates on them are tried on."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import Structure
from modallab.updating.parameterisation import parameterise
from modallab.updating.responses.target import TargetResponses, target_responses

BEAM = STRUCTURES["chapter-5-beam"]()
BAY = replace(STRUCTURES["bay"](), damping=StructuralDamping(stiffness_coefficient=0.01))
BEAM_EACH = parameterise([(member.number,) for member in BEAM.members])
BAY_EACH = parameterise([(member.number,) for member in BAY.members])
BEAM_SENSORS = tuple(Dof(node, "Y") for node in range(1, 22, 2))
BAY_NODES = (1, 3, 5, 7, 8, 10, 13, 14, 16, 18, 20, 23, 26, 28, 30)
BAY_SENSORS = tuple(Dof(node, direction) for node in BAY_NODES for direction in ("X", "Y"))
DRIVE = (Dof(1, "Y"),)
BEAM_LINES = np.linspace(10.0, 1600.0, 160)  # 13 elastic modes
BAY_LINES = np.linspace(32.0, 1280.0, 40)  # ten
AVERAGES = 100.0


def measured(
    structure: Structure, lines: FloatArray, outputs: tuple[Dof, ...], inputs: tuple[Dof, ...] = DRIVE
) -> FrfSet:
    """Return exact receptances, solved for line by line."""
    system = assemble(structure)
    values = direct_receptance(system, lines, system.selection(outputs), system.selection(inputs))
    return FrfSet(lines, values, outputs, inputs, FrfKind.RECEPTANCE)


def exact(frf: FrfSet) -> TargetResponses:
    """Return responses without random errors."""
    return target_responses(frf, np.ones(frf.values.shape[:2]), AVERAGES)


def noisy(frf: FrfSet, coherence: float, seed: int) -> TargetResponses:
    """Return responses with noise of their own, of that coherence, and with the coherence that is seen."""
    rng, loose = np.random.default_rng(seed), (1 - coherence) / coherence
    real, imaginary = np.sqrt(loose / (2 * AVERAGES)) * rng.standard_normal((2, *frf.values.shape))
    values = frf.values * (1 + real + 1j * imaginary)
    left = loose * rng.standard_gamma(AVERAGES - 1, values.shape) / AVERAGES * np.abs(frf.values) ** 2
    seen = np.abs(values) ** 2 / (np.abs(values) ** 2 + left)
    return target_responses(replace(frf, values=values), seen, AVERAGES)

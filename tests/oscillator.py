"""A structure of one DoF, and by closed form what white force makes of it."""

import numpy as np

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import ViscousDamping
from modallab.fe.structure import Structure, Support
from modallab.fe.system import DynamicSystem
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.setup import RigSetup
from tests.rigs import BAR, STEEL

LENGTH = 0.5
MASS = 13 / 35 * STEEL.density * BAR.area * LENGTH  # kg, of a clamped beam whose tip does not turn
STIFFNESS = 12 * STEEL.modulus * BAR.second_moment / LENGTH**3  # N/m
OMEGA = np.sqrt(STIFFNESS / MASS)
FREQUENCY = OMEGA / (2 * np.pi)  # 54 Hz
RATIO = 0.005  # of its damping to critical damping
DAMPING = 2 * RATIO * OMEGA * MASS  # N s/m
TIP = Dof(2, "Y")


def structure(ratio: float = RATIO) -> Structure:
    """One element, clamped at one end, guided at the other."""
    supports = (Support(1, ("Y", "RZ")), Support(2, ("RZ",)))
    law = ViscousDamping(stiffness_coefficient=2 * ratio / OMEGA)
    return beam(length=LENGTH, n_elements=1, section=BAR, material=STEEL, damping=law, supports=supports)


def system(ratio: float = RATIO) -> DynamicSystem:
    """The same, assembled: a mass on a spring and a dashpot."""
    return assemble(structure(ratio))


def rig_at_tip(level: float = 1.0, excitation: str = "random", **analyser: float | str) -> RigSetup:
    """A rig that drives and hears the tip, to ten times its natural frequency unless told otherwise."""
    setting = ExcitationSetting(excitation, level)
    settings = {"frequency_max": 540.0, "n_lines": 541, "window": "hann"} | analyser
    return RigSetup((TIP,), (TIP,), analyser=Analyser(excitation=setting, **settings))  # type: ignore[arg-type]


def density(setup: RigSetup) -> float:
    """One-sided density of the force, N^2/Hz."""
    return setup.analyser.source_level**2 / setup.analyser.frequency_max


def mean_square(power: float, stiffness: float = STIFFNESS, damping: float = DAMPING) -> float:
    """Mean square displacement, m^2, under white force of a one-sided density, N^2/Hz: G / (4 c k)."""
    return power / (4 * damping * stiffness)

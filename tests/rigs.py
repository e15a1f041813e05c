"""Beams and rigs that tests of the virtual rig share."""

from dataclasses import replace
from typing import Any

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.structure import PLANE, Material, PointMass, Section, Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.setup import RigSetup

STEEL = Material(modulus=2.09e11, density=7800.0)
BAR = Section(area=5e-4, second_moment=4.1667e-9)


def steel_beam(
    damping: Damping | None = None, n_elements: int = 20, masses: tuple[PointMass, ...] = ()
) -> Structure:
    """The free beam of chapter 5: bending modes at 23, 65, 127, 210, 313, 437, 582, 747 Hz."""
    law = damping or StructuralDamping(stiffness_coefficient=0.005, mass_coefficient=100.0)
    return beam(length=1.5, n_elements=n_elements, section=BAR, material=STEEL, damping=law, masses=masses)


def tilted_beam() -> Structure:
    """The same beam at a slope of 3 to 4: its nodes move along X and Y together."""
    straight = steel_beam()
    return replace(
        straight,
        nodes={node: (0.8 * x, 0.6 * x) for node, (x, _) in straight.nodes.items()},
        directions=PLANE,
    )


def beam_system(damping: Damping | None = None) -> DynamicSystem:
    """The same, assembled."""
    return assemble(steel_beam(damping))


def dofs(*nodes: int) -> tuple[Dof, ...]:
    """Transverse translations of nodes."""
    return tuple(Dof(node, "Y") for node in nodes)


def rig(*nodes: int, excitation: str = "periodic_random", analyser: Any = None, **parts: Any) -> RigSetup:
    """A rig that drives node 1 and listens at `nodes`; `analyser` holds what differs from the default."""
    settings = Analyser(excitation=ExcitationSetting(excitation), **(analyser or {}))
    return RigSetup(dofs(1), dofs(*nodes), analyser=settings, **parts)

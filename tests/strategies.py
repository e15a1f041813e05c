"""What hypothesis draws: structures, damping laws and what hangs on a structure."""

from hypothesis import strategies as st

from modallab.core.dof import DIRECTIONS, Dof
from modallab.fe.assembly import assemble
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.structure import Material, Member, Section, Structure, Support
from modallab.fe.system import DynamicSystem

ALLOY = Material(modulus=7e10, density=2700.0)

dofs = st.builds(
    Dof, node=st.integers(1, 999_999), direction=st.sampled_from(DIRECTIONS), sign=st.sampled_from((1, -1))
)

sections = st.builds(Section, area=st.floats(1e-4, 1e-2), second_moment=st.floats(1e-9, 1e-6))

structural = st.builds(StructuralDamping, st.floats(1e-4, 0.05), st.floats(0, 200))
viscous = st.builds(ViscousDamping, st.floats(1e-7, 1e-5), st.floats(0, 20))
modal = st.builds(ModalDamping, st.lists(st.floats(1e-4, 0.05), min_size=1, max_size=4).map(tuple))
dampings: st.SearchStrategy[Damping] = structural | viscous | modal

FREE: tuple[Support, ...] = ()
PINNED = (Support(1, ("X", "Y")),)
CLAMPED = (Support(1, ("X", "Y", "RZ")),)


@st.composite
def frames(draw: st.DrawFn, damping: st.SearchStrategy[Damping] = dampings) -> Structure:
    """A plane frame of a few bars, bent at its nodes, free or held at its first one."""
    n_nodes = draw(st.integers(3, 6))
    heights = draw(st.lists(st.floats(-1, 1), min_size=n_nodes, max_size=n_nodes))
    section = draw(sections)
    bars = [(i, i + 1) for i in range(1, n_nodes)]
    if draw(st.booleans()):
        bars.append((n_nodes, 1))
    lost = st.none() | st.floats(0, 0.2)
    return Structure(
        nodes={i + 1: (0.7 * i, y) for i, y in enumerate(heights)},
        members=tuple(
            Member(i + 1, ends, section, ALLOY, loss_factor=draw(lost)) for i, ends in enumerate(bars)
        ),
        supports=draw(st.sampled_from((FREE, PINNED, CLAMPED))),
        damping=draw(damping),
    )


@st.composite
def loaded_systems(draw: st.DrawFn) -> DynamicSystem:
    """A frame with a mass, a spring to ground and a changed member hanging on it."""
    structure = draw(frames())
    system = assemble(structure)
    node, dof = draw(st.sampled_from([d for d in structure.dofs if d.translational])).node, structure.dofs[-1]
    if draw(st.booleans()):
        system = system.add_mass(node, draw(st.floats(1e-3, 1.0)))
    if draw(st.booleans()):
        system = system.add_spring(dof, draw(st.floats(1.0, 1e5)))
    if draw(st.booleans()):
        shares = st.floats(-0.5, 2.0)
        system = system.change_member(1, mass=draw(shares), axial=draw(shares), bending=draw(shares))
    return system

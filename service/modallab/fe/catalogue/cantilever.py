"""The beam of the 1992 thesis, chapter 5, clamped at node 1."""

from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure, Support


@STRUCTURES.register("cantilever")
def cantilever() -> Structure:
    """A steel cantilever, 1.5 m in 20 elements, clamped at node 1."""
    return beam(
        length=1.5,
        n_elements=20,
        section=Section(area=5e-4, second_moment=4.1667e-9),
        material=Material(modulus=2.09e11, density=7800.0),
        damping=StructuralDamping(stiffness_coefficient=0.005, mass_coefficient=100.0),
        supports=(Support(1, ("Y", "RZ")),),
        name="cantilever",
    )

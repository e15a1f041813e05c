"""The free beam of the 1992 thesis, chapter 5: steel, 1.5 m, 20 elements."""

from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure


@STRUCTURES.register("chapter-5-beam")
def chapter_5_beam() -> Structure:
    """A free-free steel beam, 1.5 m in 20 elements, eight bending modes below 800 Hz."""
    return beam(
        length=1.5,
        n_elements=20,
        section=Section(area=5e-4, second_moment=4.1667e-9),
        material=Material(modulus=2.09e11, density=7800.0),
        damping=StructuralDamping(stiffness_coefficient=0.005, mass_coefficient=100.0),
        name="chapter-5-beam",
    )

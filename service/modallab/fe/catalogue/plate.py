"""A free rectangular plate of steel."""

from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Structure


@STRUCTURES.register("plate")
def free_plate() -> Structure:
    """A free steel plate, 0.6 m by 0.4 m, 4 mm thick, in 12 by 8 Mindlin elements: 351 DoFs."""
    return plate(
        length=0.6,
        width=0.4,
        thickness=0.004,
        n_elements=(12, 8),
        material=Material(modulus=2.09e11, density=7800.0, name="steel"),
        damping=StructuralDamping(stiffness_coefficient=0.002),
        name="plate",
    )

"""The structures whose bulk data lie beside this file, as JSON for what writes them."""

import json
from dataclasses import replace
from typing import Any

from modallab.core.dof import DIRECTIONS, Dof
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.plate import plate
from modallab.fe.structure import GroundSpringElement, Material, PointMass, Section, Structure, Support

STEEL = Material(modulus=2.09e11, density=7800.0)
MASS, SPRING = 12.5, 3e7  # kg at node 8, N/m from 20:+Y to the ground
HELD = Support(3, ("X", "Y"))


def bay() -> Structure:
    """The bay of the catalogue, free."""
    return STRUCTURES["bay"]()


def loaded_bay() -> Structure:
    """The same with a mass and a spring, held at a node."""
    free = bay()
    return replace(
        free,
        masses=(PointMass(8, MASS),),
        springs=(GroundSpringElement(Dof(20, "Y"), SPRING),),
        supports=(HELD,),
    )


def free_plate() -> Structure:
    """A free steel plate, 0.6 m by 0.4 m, 4 mm thick."""
    return plate(length=0.6, width=0.4, thickness=0.004, n_elements=(6, 4), material=STEEL)


def line() -> Structure:
    """A free steel beam of six elements."""
    return beam(length=1.5, n_elements=6, section=Section(5e-4, 4.1667e-9), material=STEEL)


def held_line() -> Structure:
    """The same, clamped at its first node."""
    return replace(line(), supports=(Support(1, ("Y", "RZ")),))


def described() -> dict[str, Any]:
    """Return nodes and elements of both, and the matrices of the beam, by name."""
    frame, flat = bay(), free_plate()
    system = assemble(line())
    return {
        "bay": {
            "nodes": dict(frame.nodes),
            "bars": [
                [
                    m.number,
                    *m.nodes,
                    m.section.area,
                    m.section.second_moment,
                    m.material.modulus,
                    m.material.density,
                ]
                for m in frame.members
            ],
        },
        "plate": {
            "nodes": dict(flat.nodes),
            "rims": [[m.number, *m.nodes] for m in flat.non_bar_members],
            "thickness": 0.004,
            "material": [STEEL.modulus, STEEL.poisson_ratio, STEEL.density],
        },
        "beam": {
            "dofs": [[dof.node, DIRECTIONS.index(dof.direction) + 1] for dof in line().dofs],
            "places": dict(line().nodes),
            "mass": system.mass.toarray().tolist(),
            "stiffness": system.stiffness.toarray().tolist(),
        },
        "loads": {"mass": [8, MASS], "spring": [20, SPRING], "held": 3},
    }


if __name__ == "__main__":
    print(json.dumps(described()))  # noqa: T201

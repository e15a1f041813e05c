"""Writes the meshes beside it, with gmsh 4.15 in an environment of its own.

python -m venv /tmp/gmsh && /tmp/gmsh/bin/pip install gmsh
/tmp/gmsh/bin/python tests/service/interchange/mesh/write_with_gmsh.py
"""

from importlib import import_module
from pathlib import Path

HERE = Path(__file__).parent
LENGTH, WIDTH = 600.0, 400.0  # mm


def main() -> None:
    """Write a plate of two halves, quadrilaterals and triangles, a rib between them, a side with a name."""
    gmsh = import_module("gmsh")
    gmsh.initialize()
    geometry, mesh = gmsh.model.geo, gmsh.model.mesh
    half = LENGTH / 2
    corners = ((0, 0), (half, 0), (LENGTH, 0), (LENGTH, WIDTH), (half, WIDTH), (0, WIDTH))
    for number, (x, y) in enumerate(corners, 1):
        geometry.addPoint(x, y, 0, 200, number)
    for number, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1), (2, 5)), 1):
        geometry.addLine(a, b, number)
    for number, loop in enumerate(([1, 7, 5, 6], [2, 3, 4, -7]), 1):
        geometry.addCurveLoop(loop, number)
        geometry.addPlaneSurface([number], number)
    geometry.synchronize()
    for curve in range(1, 8):
        mesh.setTransfiniteCurve(curve, 6 if curve in (3, 6, 7) else 5)
    for surface in (1, 2):
        mesh.setTransfiniteSurface(surface)
    mesh.setRecombine(2, 1)
    for dimension, entity, name in ((2, 1, "thin"), (2, 2, "thick half"), (1, 6, "left"), (1, 7, "rib")):
        gmsh.model.addPhysicalGroup(dimension, [entity], name=name)
    mesh.generate(2)
    for version, binary, name in ((4.1, 0, "gmsh_41"), (4.1, 1, "gmsh_41_binary"), (2.2, 0, "gmsh_22")):
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(HERE / f"{name}.msh"))


if __name__ == "__main__":
    main()

"""Writes the files beside it, with pyNastran 1.4.1 and pyyeti 1.4.7 in an environment of its own: numpy 1.26.

    python -m venv /tmp/nastran && /tmp/nastran/bin/pip install pyNastran==1.4.1 pyyeti==1.4.7 "numpy<2"
    python -m tests.service.interchange.nastran.described | /tmp/nastran/bin/python \
        tests/service/interchange/nastran/write_with_pynastran.py
"""

import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

BDF = import_module("pyNastran.bdf.bdf").BDF
OP4 = import_module("pyNastran.op4.op4").OP4
yeti = import_module("pyyeti.nastran.op4")

HERE = Path(__file__).parent
ACROSS = "345"  # of a frame in X, Y: what it does not move by
ALONG = "126"  # of a plate


def frame(bay: dict[str, Any], *, beams: bool = False) -> Any:
    model = BDF(debug=False)
    nodes = {int(number): place for number, place in bay["nodes"].items()}
    for number, (x, y) in nodes.items():
        model.add_grid(number, [x, y, 0.0], ps=ACROSS)
    kinds: dict[tuple[float, ...], int] = {}
    for number, one, other, area, second, modulus, density in bay["bars"]:
        kind = (area, second, modulus, density)
        if kind not in kinds:
            kinds[kind] = pid = len(kinds) + 1
            model.add_mat1(pid, modulus, None, 0.3, rho=density)
            if beams:
                stations: dict[str, Any] = {"xxb": [0.0, 1.0], "so": ["YES", "YES"]}
                sections = {"area": [area] * 2, "i1": [second] * 2, "i2": [second] * 2, "i12": [0.0] * 2}
                model.add_pbeam(pid, pid, **stations, **sections, j=[second] * 2, k1=0.0, k2=0.0)
            else:
                model.add_pbar(pid, pid, area, i1=second, i2=second, j=second)
        (x1, y1), (x2, y2) = nodes[one], nodes[other]
        upright = [-(y2 - y1), x2 - x1, 0.0]
        add = model.add_cbeam if beams else model.add_cbar
        add(number, kinds[kind], [one, other], upright, None)
    return model


def plate(flat: dict[str, Any], *, triangles: bool = False) -> Any:
    model = BDF(debug=False)
    for number, (x, y) in flat["nodes"].items():
        model.add_grid(int(number), [x, y, 0.0], ps=ALONG)
    modulus, nu, density = flat["material"]
    model.add_mat1(1, modulus, None, nu, rho=density)
    model.add_pshell(10, 1, flat["thickness"], 1, mid3=1)
    for number, a, b, c, d in flat["rims"]:
        if triangles:
            model.add_ctria3(2 * number - 1, 10, [a, b, c])
            model.add_ctria3(2 * number, 10, [a, c, d])
        else:
            model.add_cquad4(number, 10, [a, b, c, d])
    return model


def direct(line: dict[str, Any], *, symmetric: bool, double: bool) -> Any:
    model = BDF(debug=False)
    for number, (x, y) in line["places"].items():
        # seven digits are no free body: its motions would strain by the rounding
        clamped = number == "1" and not double
        model.add_grid(int(number), [x, y, 0.0], ps="123456" if clamped else "1345")
    for name, matrix in (("KAAX", line["stiffness"]), ("MAAX", line["mass"])):
        n = len(matrix)
        at = [(i, j) for j in range(n) for i in range(j if symmetric else 0, n) if matrix[i][j]]
        rows, columns = ([tuple(line["dofs"][pair[k]]) for pair in at] for k in (0, 1))
        values = [matrix[i][j] for i, j in at]
        tin = 2 if double else 1
        model.add_dmig(name, 6 if symmetric else 1, tin, 0, 0, n, columns, rows, values)
    return model


def matrices(line: dict[str, Any]) -> None:
    both = {name: np.array(line[kind]) for name, kind in (("KXX", "stiffness"), ("MXX", "mass"))}
    dense = {name: (6, matrix) for name, matrix in both.items()}
    # of its writers those of sparse and of binary matrices are at fault
    OP4(debug=False).write_op4(str(HERE / "dense_text.op4"), dense, is_binary=False)
    yeti.write(str(HERE / "dense_binary.op4"), both)
    for form in ("bigmat", "nonbigmat"):
        yeti.write(str(HERE / f"{form}_text.op4"), both, binary=False, sparse=form)
    yeti.write(str(HERE / "bigmat_binary.op4"), both, sparse="bigmat", endian=">")
    yeti.write(str(HERE / "nonbigmat_binary.op4"), both, sparse="nonbigmat")


def main() -> None:
    """Write all files."""
    given = json.load(sys.stdin)
    frame(given["bay"]).write_bdf(str(HERE / "bay_8.bdf"), size=8)
    frame(given["bay"]).write_bdf(str(HERE / "bay_16.bdf"), size=16)
    loaded = frame(given["bay"], beams=True)
    (at, mass), (spring_at, stiffness) = given["loads"]["mass"], given["loads"]["spring"]
    loaded.add_conm2(1001, at, mass)
    loaded.add_celas2(1002, stiffness, [spring_at, 0], c1=2)
    loaded.add_spc1(7, "12", [given["loads"]["held"]])
    loaded.write_bdf(str(HERE / "loaded_bay.bdf"), size=16, is_double=True)
    plate(given["plate"]).write_bdf(str(HERE / "plate.bdf"), size=16)
    direct(given["beam"], symmetric=True, double=True).write_bdf(str(HERE / "direct.bdf"))
    direct(given["beam"], symmetric=False, double=False).write_bdf(str(HERE / "direct_square.bdf"))
    matrices(given["beam"])
    plate(given["plate"], triangles=True).write_bdf(str(HERE / "triangles.bdf"), size=8)


if __name__ == "__main__":
    main()

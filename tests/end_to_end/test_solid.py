"""A solid of bricks from elsewhere: element matrices imported, measured on the rig, groups corrected."""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab_client import ModalLab, Structure
from modallab_client.results import IterativeUpdate

Array = NDArray[np.float64]
MODULUS, POISSON, DENSITY = 7e10, 0.3, 2700.0
SIZE, COUNT = (0.4, 0.06, 0.04), (8, 2, 2)  # m, bricks
CORNERS = np.array(list(product((-1, 1), repeat=3)), float)
DAMPING = {"law": "structural", "stiffness_coefficient": 0.01}


def brick(edges: Array) -> tuple[Array, Array]:
    """Return mass and stiffness (24, 24) of a trilinear brick by 2 x 2 x 2 points of Gauss.

    Hughes, The Finite Element Method (1987), chapter 3.
    """
    lame = MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = MODULUS / (2 * (1 + POISSON))
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    mass, stiffness, volume = np.zeros((24, 24)), np.zeros((24, 24)), edges.prod() / 8
    for point in CORNERS / np.sqrt(3):
        factors = 1 + CORNERS * point
        value = factors.prod(axis=1) / 8
        slope = [CORNERS[:, i] * np.delete(factors, i, axis=1).prod(axis=1) / 4 / edges[i] for i in range(3)]
        strain = np.zeros((6, 24))
        for i in range(3):
            strain[i, i::3] = slope[i]
        for row, (i, k) in enumerate(((0, 1), (1, 2), (2, 0)), start=3):
            strain[row, i::3], strain[row, k::3] = slope[k], slope[i]
        stiffness += volume * strain.T @ law @ strain
        moved = np.kron(value, np.eye(3))
        mass += volume * DENSITY * moved.T @ moved
    return mass, (stiffness + stiffness.T) / 2


def npz() -> bytes:
    """Return a block of bricks, those of its halves in groups, as the service takes matrices by element."""
    edges = np.array(SIZE) / COUNT
    grid = np.arange(np.prod(np.array(COUNT) + 1)).reshape(np.array(COUNT) + 1)
    bricks = list(product(*map(range, COUNT)))
    nodes = np.array([grid[i : i + 2, j : j + 2, k : k + 2].ravel() for i, j, k in bricks])
    mass, stiffness = brick(edges)
    file = io.BytesIO()
    np.savez(
        file,
        dofs=np.array([f"{n + 1}:+{direction}" for n in range(grid.size) for direction in "XYZ"]),
        element_dofs=(3 * nodes[:, :, None] + np.arange(3)).reshape(len(bricks), 24),
        element_mass=np.stack([mass] * len(bricks)),
        element_stiffness=np.stack([stiffness] * len(bricks)),
        element_groups=np.array(["root" if i < COUNT[0] // 2 else "tip" for i, _, _ in bricks]),
        nodes=np.arange(grid.size) + 1,
        coordinates=np.array(list(np.ndindex(grid.shape))) * edges,
    )
    return file.getvalue()


@dataclass(frozen=True)
class Case:
    """A model, and a structure of which one half is stiffer and the other heavier."""

    lab: ModalLab
    model: Structure
    truth: Structure
    sensors: list[str]


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Case]:
    path = Path(tmp_path_factory.mktemp("solid") / "block.npz")
    path.write_bytes(npz())
    with ModalLab.embedded() as lab:
        model = lab.structures.upload(str(path), damping=DAMPING)
        changes = [
            {"members": model.groups["tip"], "property": "modulus", "factor": 1.3},
            {"members": model.groups["root"], "property": "density", "factor": 1.1},
        ]
        top = range(COUNT[2] + 1, model.n_nodes + 1, COUNT[2] + 1)  # the highest node of each upright
        sensors = [f"{node}:+{direction}" for node in top for direction in "YZ"]
        yield Case(lab, model, lab.structures.change(model.id, changes), sensors)


def test_a_block_is_free_and_as_stiff_along_as_its_material(case: Case) -> None:
    modes = case.lab.structures.modes(case.model.id, count=6)
    assert modes.n_rigid_body == 6
    # along: c / 2 L of a bar with free ends, and hardly more of one so slender
    along = np.sqrt(MODULUS / DENSITY) / (2 * SIZE[0])
    assert np.abs(modes.frequencies / along - 1).min() < 0.01


def test_its_groups_are_corrected_from_a_test_on_the_rig(case: Case) -> None:
    lab, model = case.lab, case.model
    highest = 1.1 * lab.structures.modes(model.id, count=5).frequencies[-1]
    rig = lab.rigs.create(
        drive=case.sensors[1],
        responses=case.sensors,
        analyser={"frequency_max": float(highest), "n_lines": 801},
    )
    test = lab.measurements.start(case.truth.id, rig.id, route="expected").result()
    modes = lab.modal_models.start(test.id, method="lscf").result()
    assert len(modes.frequencies) == 5
    update = lab.updates.start(model.id, modes.id, method="one_shot", macros=["root", "tip"]).result()
    assert update.converged, update.stopped_because
    for group, mass, stiffness in (("root", 1.1, 1.0), ("tip", 1.0, 1.3)):
        for member in model.groups[group]:
            # modes above the band are left to residuals of two terms: 1e-4 of a frequency
            assert update.coefficients["mass"][member] == pytest.approx(mass, rel=1e-3)
            assert update.coefficients["stiffness"][member] == pytest.approx(stiffness, rel=1e-3)


def test_single_bricks_are_found_among_all(case: Case) -> None:
    lab, model = case.lab, case.model
    softer = lab.structures.change(model.id, members=[13, 14], property="modulus", factor=0.7)
    modes = lab.structures.synthetic_modes(softer.id, dofs=case.sensors, count=6)
    update = lab.updates.start(
        model.id, modes.id, method="one_shot", macros="each", parts=["stiffness"]
    ).result()
    assert isinstance(update, IterativeUpdate)
    assert update.suspected == {"stiffness": (13, 14)}
    # exact modes: quadratic convergence below the last step's tolerance of 1e-4
    assert update.coefficients["stiffness"][13] == pytest.approx(0.7, abs=1e-6)

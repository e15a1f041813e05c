from dataclasses import replace

import numpy as np
import pytest

import modallab.fe.receptance_map as module
from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.receptance import receptance
from modallab.fe.receptance_map import ReceptanceMap
from modallab.fe.settings import CACHE
from modallab.fe.system import DynamicSystem
from tests.diagnosing import model

FREQ = np.linspace(1.0, 400.0, 50)


def loaded() -> list[DynamicSystem]:
    """Return a beam with a spring in all variants, and a mass of each one's own or none."""
    bare = assemble(model()).add_spring(Dof(2, "Y"), 1e5)
    return [bare.add_mass(3, 0.1), bare.add_mass(7, 0.2), bare]


@pytest.mark.parametrize("room", [2**22, 0], ids=["all kept", "nothing kept"])
def test_receptances_to_any_columns_are_those_of_each_loaded_structure(
    room: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "CACHE", replace(CACHE, receptance_map_values=room))
    systems = loaded()
    lefts = [
        system.selection((Dof(1, "Y"), Dof(n, "Y"))) for system, n in zip(systems, (3, 5, 9), strict=True)
    ]
    reach = ReceptanceMap(systems, 2 * np.pi * FREQ, lefts)
    columns = systems[0].selection((Dof(4, "Y"), Dof(4, "RZ"), Dof(8, "Y"))) @ [
        [1.0, 0.5],
        [0.0, 2.0],
        [-1.0, 0.0],
    ]
    across, within = reach.to(columns)
    for system, left, to_b, own in zip(systems, lefts, across, within, strict=True):
        # Two ways to solve for the same: rounding, enlarged at the resonances of a lightly damped beam.
        np.testing.assert_allclose(to_b, receptance(system, FREQ, left, columns), rtol=1e-8)
        np.testing.assert_allclose(own, receptance(system, FREQ, columns, columns), rtol=1e-8)


def test_many_attachments_are_folded_into_the_matrices() -> None:
    system = loaded()[2]
    for node in range(1, 10):
        system = system.add_mass(node, 0.01 * node)
    left, column = system.selection((Dof(1, "Y"),)), system.selection((Dof(6, "Y"),))
    (found,), _ = ReceptanceMap([replace(system)], 2 * np.pi * FREQ, [left]).to(column)
    np.testing.assert_allclose(found, receptance(system, FREQ, left, column), rtol=1e-8)

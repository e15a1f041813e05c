import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.system import DynamicSystem

CANTILEVER, BEAM, BAY = (assemble(STRUCTURES[n]()) for n in ("cantilever", "chapter-5-beam", "bay"))
MASTERS = tuple(Dof(node, "Y") for node in range(3, 22, 2))


def test_static_forces_on_masters_move_all_dofs_exactly() -> None:
    reduced = reduce(CANTILEVER, MASTERS, reduction_of("guyan"))
    forces = np.random.default_rng(1).standard_normal(len(MASTERS))
    full = np.linalg.solve(CANTILEVER.stiffness.toarray(), CANTILEVER.selection(MASTERS) @ forces)
    found = reduced.transformation @ np.linalg.solve(reduced.stiffness, forces)
    np.testing.assert_allclose(found, full, rtol=1e-7, atol=1e-9 * np.abs(full).max())  # condition 1e7


def test_rigid_body_motion_stays_rigid_and_weighs_what_it_did() -> None:
    reduced = reduce(BEAM, MASTERS, reduction_of("guyan"))
    heave = reduced.transformation @ np.ones(len(MASTERS))
    turning = np.array([dof.direction == "RZ" for dof in BEAM.dofs])
    np.testing.assert_allclose(heave[~turning], 1.0, rtol=1e-9)
    np.testing.assert_allclose(heave[turning], 0.0, atol=1e-8)  # rounding of a slope, rad per m
    assert reduced.mass.sum() == pytest.approx(5e-4 * 7800 * 1.5, rel=1e-9)  # area density length


def test_frequency_errors_grow_with_frequency_squared() -> None:
    reduced, _ = reduce(CANTILEVER, MASTERS, reduction_of("guyan")).modes()
    full = CANTILEVER.modes().frequencies
    error = np.log(reduced[1:4] / full[1:4] - 1)
    # followers are wrong by O(lambda), energies by its square, so lambda by lambda^2 in lambda
    slopes = np.diff(error) / np.diff(np.log(full[1:4] ** 2))
    np.testing.assert_allclose(slopes, 1.0, atol=0.05)  # the next order, at a tenth of the slaves' first mode


def assert_loose(system: DynamicSystem, masters: tuple[Dof, ...], what: str) -> None:
    for kind in ("guyan", "irs", "dynamic"):
        with pytest.raises(InvalidInputError, match=what) as caught:
            reduce(system, masters, reduction_of(kind))
        assert caught.value.context["field"] == "reduction"
        assert "serep" in str(caught.value.context["allowed"])


def test_masters_that_leave_a_free_structure_free_are_refused() -> None:
    across = tuple(dof for dof in BAY.dofs if dof.direction == "Y")
    assert_loose(BAY, across, r"1 of 3 rigid-body motions")
    assert_loose(BEAM, (Dof(1, "Y"),), r"1 of 2 rigid-body motions")
    assert_loose(BEAM, (Dof(1, "RZ"),), r"1 of 2 rigid-body motions")


def test_a_part_that_nothing_holds_is_found_without_knowing_the_geometry() -> None:
    blind = DynamicSystem(mass=BEAM.mass, stiffness=BEAM.stiffness, dofs=BEAM.dofs)
    assert_loose(blind, (Dof(1, "RZ"),), "a part of it")

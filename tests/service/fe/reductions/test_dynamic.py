import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.system import DynamicSystem

CANTILEVER, BAY = (assemble(STRUCTURES[name]()) for name in ("cantilever", "bay"))
MASTERS = tuple(Dof(node, "Y") for node in range(3, 22, 4))


@pytest.mark.parametrize("mode", [0, 2, 4])
def test_a_mode_at_the_frequency_is_exact(mode: int) -> None:
    full = CANTILEVER.modes()
    frequency = full.frequencies[mode]
    reduced = reduce(CANTILEVER, MASTERS, reduction_of("dynamic", {"frequency": frequency}))
    found, shapes = reduced.modes()
    near = np.abs(found - frequency).argmin()
    assert found[near] == pytest.approx(frequency, rel=1e-8)  # rounding; errors enter squared
    shape = reduced.transformation @ shapes[:, near]
    exact = full.shapes[:, mode].real
    np.testing.assert_allclose(shape * np.sign(shape @ exact), exact, atol=1e-6 * np.abs(exact).max())


def test_forces_on_masters_at_the_frequency_move_all_dofs_exactly() -> None:
    frequency = 50.0
    reduced = reduce(CANTILEVER, MASTERS, reduction_of("dynamic", {"frequency": frequency}))
    square = (2 * np.pi * frequency) ** 2
    stiffness = (CANTILEVER.stiffness - square * CANTILEVER.mass).toarray()
    forces = np.arange(1.0, 6.0)
    full = np.linalg.solve(stiffness, CANTILEVER.selection(MASTERS) @ forces)
    small = np.linalg.solve(reduced.stiffness - square * reduced.mass, forces)
    np.testing.assert_allclose(
        reduced.transformation @ small, full, atol=1e-8 * np.abs(full).max()
    )  # rounding


def test_at_rest_it_is_the_static_one() -> None:
    static, dynamic = (
        reduce(CANTILEVER, MASTERS, reduction_of(k)).transformation for k in ("guyan", "dynamic")
    )
    np.testing.assert_array_equal(static, dynamic)


def test_a_structure_that_masters_leave_free_has_an_answer_above_0_hz() -> None:
    across = tuple(dof for dof in BAY.dofs if dof.direction == "Y")
    frequency = BAY.modes().elastic().frequencies[0]
    found, _ = reduce(BAY, across, reduction_of("dynamic", {"frequency": frequency})).modes()
    assert np.abs(found - frequency).min() < 1e-6 * frequency  # rounding


def test_at_a_resonance_of_the_held_structure_there_is_none() -> None:
    # one mass on one spring between two masters: held, it resonates at sqrt(2 k/m)
    dofs = tuple(Dof(node, "X") for node in (1, 2, 3))
    chain = csc_array(np.array([[1.0, -1, 0], [-1, 2, -1], [0, -1, 1]]))
    system = DynamicSystem(mass=csc_array(np.diag([1.0, 2.0, 1.0])), stiffness=chain, dofs=dofs)
    held = 1 / (2 * np.pi)  # Hz, of 2 N/m on 2 kg
    with pytest.raises(InvalidInputError, match=r"resonates at 0\.159155 Hz") as caught:
        reduce(system, (dofs[0], dofs[2]), reduction_of("dynamic", {"frequency": held}))
    assert caught.value.context["field"] == "reduction"

"""Motion of a point between the nodes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from modallab.fe.assembly import assemble
from modallab.fe.interpolation import point_motion
from modallab.fe.member_table import MemberTable
from modallab.fe.structure import Material, Member, Section, Structure
from modallab.fe.system import DynamicSystem
from tests.rigs import steel_beam, tilted_beam
from tests.strategies import frames


def table_of(system: DynamicSystem) -> MemberTable:
    assert system.members is not None
    return system.members


def place(structure: Structure, node: int, distance: float) -> tuple[float, float]:
    """Where the point is: a small turn about the origin moves it by (-y, x)."""
    system = assemble(structure)
    points = [structure.nodes[dof.node] for dof in system.dofs]
    turn = {"X": [-y for _, y in points], "Y": [x for x, _ in points], "RZ": [1.0] * len(points)}
    motion = np.array([turn[dof.direction][i] for i, dof in enumerate(system.dofs)])
    x, y = (
        sum(weight * motion[row] for row, weight in point_motion(table_of(system), node, distance, direction))
        for direction in ("Y", "X")
    )
    return float(x), float(-y)


@given(
    structure=frames().filter(lambda one: not one.supports), node=st.integers(1, 3), share=st.floats(-1, 1)
)
def test_a_rigid_turn_takes_the_point_along_wherever_it_is(
    structure: Structure, node: int, share: float
) -> None:
    here = np.array(structure.nodes[node])
    lengths = [structure.length(m) for m in structure.members if node in m.nodes]
    distance = share * min(lengths)
    x, y = place(structure, node, distance)
    # straight along a member from the node; rounding of sums of numbers of order 1
    assert np.isclose(np.hypot(*(np.array([x, y]) - here)), abs(distance), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("distance", [0.03, -0.03, 0.1, -0.2, 2.0, -2.0])
def test_along_a_straight_beam_it_walks_from_member_to_member_and_out_beyond_the_end(distance: float) -> None:
    x, y = place(tilted_beam(), 7, distance)
    along = 6 * 0.075 + distance
    np.testing.assert_allclose([x, y], [0.8 * along, 0.6 * along], rtol=1e-10, atol=1e-12)  # rounding


def test_where_all_members_start_the_second_one_is_the_way_back() -> None:
    bar, alloy = Section(1e-4, 1e-9), Material(7e10, 2700.0)
    members = tuple(Member(i, (2, end), bar, alloy) for i, end in ((1, 1), (2, 3)))
    bent = Structure({1: (-1.0, 0.0), 2: (0.0, 0.0), 3: (0.0, 1.0)}, members)
    np.testing.assert_allclose(place(bent, 2, 0.25), (-0.25, 0.0), atol=1e-12)
    np.testing.assert_allclose(place(bent, 2, -0.25), (0.0, 0.25), atol=1e-12)
    np.testing.assert_allclose(place(bent, 1, -1.25), (0.0, 0.25), atol=1e-12)  # round the corner
    np.testing.assert_allclose(place(bent, 1, 1.25), (-2.25, 0.0), atol=1e-12)  # beyond the end


def test_a_mode_between_nodes_is_that_of_the_free_beam_in_closed_form() -> None:
    """cosh bx + cos bx - s (sinh bx + sin bx), cosh bL cos bL = 1 (Blevins 1979, table 8-1)."""
    b = brentq(lambda v: np.cosh(v) * np.cos(v) - 1, 10.5, 11.5) / 1.5  # third elastic mode
    s = (np.cosh(1.5 * b) - np.cos(1.5 * b)) / (np.sinh(1.5 * b) - np.sin(1.5 * b))

    def exact(x: float) -> float:
        return float(np.cosh(b * x) + np.cos(b * x) - s * (np.sinh(b * x) + np.sin(b * x)))

    system = assemble(steel_beam())
    shape = system.modes().elastic().shapes[:, 2].real
    scale = exact(0.0) / shape[0]
    for distance in (0.0375, 0.02, -0.0375):
        found = scale * sum(w * shape[r] for r, w in point_motion(table_of(system), 9, distance, "Y"))
        # a cubic misses (b l)^4/384 = 2.4e-4 of the wave, whose size is 2; the nodes themselves 1e-5
        assert abs(found - exact(8 * 0.075 + distance)) < 5e-4
        assert abs(scale * shape[16] - exact(0.6)) < 5e-5

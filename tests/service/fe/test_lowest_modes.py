"""The lowest modes of a large system: as many as there are, from a dense solution of the same matrices."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import block_diag, csc_array

from modallab.core.arrays import FloatArray
from modallab.core.errors import StructureError
from modallab.fe import lowest_modes
from modallab.fe.assembly import assemble
from modallab.fe.lowest_modes import LowestModes, count_below, lowest_below, lowest_first
from modallab.fe.modes import rigid_body_modes
from modallab.fe.plate import Edge, Holding, plate
from modallab.fe.structure import Material
from modallab.fe.system import DynamicSystem

STEEL = Material(2.09e11, 7800.0)


def square_plate(thickness: float = 0.004, *, held: bool = False) -> DynamicSystem:
    """Return a plate of which every other mode is one of two at a frequency: 363 DoFs when free."""
    edges = dict.fromkeys(Edge, Holding.CLAMPED) if held else {}
    return assemble(
        plate(length=0.4, width=0.4, thickness=thickness, n_elements=(10, 10), material=STEEL, edges=edges)
    )


def bodies_of(system: DynamicSystem) -> FloatArray:
    return rigid_body_modes(system.mass, system.stiffness, system.rigid)


def dense(system: DynamicSystem) -> FloatArray:
    return np.asarray(eigh(system.stiffness.toarray(), system.mass.toarray(), eigvals_only=True))


def check(found: LowestModes, mass: csc_array, stiffness: csc_array, exact: FloatArray) -> None:
    """Compare with eigenvalues (m,), and the shapes with what modes must be."""
    # the dense solution loses the ratio of the largest eigenvalue to them, 1e9, times 1e-16
    np.testing.assert_allclose(found.squares, exact, rtol=1e-5, atol=1e-7 * exact.max())
    gram = found.shapes.T @ (mass @ found.shapes)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-8)  # rounding over small gaps
    left = stiffness @ found.shapes - mass @ found.shapes * found.squares
    # as forces that stiffness has between its entries, which cancel to 1e-9 of themselves in a mode
    size = abs(stiffness) @ np.abs(found.shapes)
    assert np.abs(left).max() < 1e-8 * size.max()


@pytest.mark.parametrize("thickness", [0.004, 1e-4], ids=["plate", "foil"])
@pytest.mark.parametrize("count", [1, 4, 20])
def test_modes_by_number_are_the_first_ones(count: int, thickness: float) -> None:
    system = square_plate(thickness)
    found = lowest_first(system.mass, system.stiffness, bodies_of(system), count)
    n = len(found.squares)
    assert count + 3 <= n <= count + 4  # the second one of a pair comes along
    if thickness > 1e-4:  # what bends a foil is lost in the rounding of a dense solution
        exact = np.concatenate([np.zeros(3), dense(system)[3:n]])
        check(found, system.mass, system.stiffness, exact)
    else:
        thicker = square_plate(1e-3)
        again = lowest_first(thicker.mass, thicker.stiffness, bodies_of(thicker), count)
        # thin plates are alike but for shear, (thickness/wavelength)^2: 1e-3 of the highest one's stiffness
        np.testing.assert_allclose(found.squares[3:n] * 1e2, again.squares[3:n], rtol=2e-3)


def test_modes_by_number_end_where_there_are_no_more() -> None:
    system = square_plate(held=True)
    n = len(system.dofs)
    found = lowest_first(system.mass, system.stiffness, np.zeros((n, 0)), 2 * n)
    assert len(found.squares) == n
    assert found.highest == np.inf


def test_a_band_holds_every_mode_below_its_end() -> None:
    system = square_plate()
    exact = dense(system)
    for highest in (0.5 * exact[3], 1.5 * exact[12], 1.5 * exact[150]):
        found = lowest_below(system.mass, system.stiffness, bodies_of(system), highest)
        inside = exact[exact < highest][3:]
        check(found, system.mass, system.stiffness, np.concatenate([np.zeros(3), inside]))


def test_a_band_whose_modes_cannot_be_counted_holds_them_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system = square_plate()
    exact = dense(system)
    monkeypatch.setattr("modallab.fe.lowest_modes.count_below", lambda *_: None)
    found = lowest_below(system.mass, system.stiffness, bodies_of(system), 1.5 * exact[40])
    inside = exact[exact < 1.5 * exact[40]][3:]
    assert len(inside) > 20  # more than are looked for first
    check(found, system.mass, system.stiffness, np.concatenate([np.zeros(3), inside]))


def test_a_band_below_the_first_elastic_mode_holds_rigid_ones_alone() -> None:
    system = square_plate()
    found = lowest_below(system.mass, system.stiffness, bodies_of(system), 0.5 * dense(system)[3])
    assert (found.squares == 0).all()
    assert len(found.squares) == 3


def test_eigenvalues_are_counted_without_being_solved_for() -> None:
    system = square_plate()
    exact = dense(system)
    for place in (0, 3, 5, 40, 200):
        between = float(exact[place : place + 2].mean())
        expected = int((exact < between).sum())
        assert count_below(system.mass, system.stiffness, max(between, 1.0)) == max(expected, 3)


def test_both_of_two_modes_that_nothing_tells_apart_are_found() -> None:
    system = square_plate(held=True)
    # two plates with nothing between them: a single start shows one mode at each frequency
    mass, stiffness = (csc_array(block_diag([a, a])) for a in (system.mass, system.stiffness))
    exact = np.repeat(dense(system)[:9], 2)
    none = np.zeros((mass.shape[0], 0))
    found = lowest_below(mass, stiffness, none, 1.0001 * exact[-1])
    check(found, mass, stiffness, exact)
    # from modes of one of the plates alone
    one_sided = np.vstack([found.shapes[: len(system.dofs)], 0 * found.shapes[len(system.dofs) :]])
    again = lowest_below(mass, stiffness, none, 1.0001 * exact[-1], one_sided)
    check(again, mass, stiffness, exact)


def test_modes_of_a_system_much_like_it_lead_to_the_same_modes() -> None:
    system, stiffer = square_plate(), square_plate(0.0042)
    bodies = bodies_of(stiffer)
    near = lowest_first(system.mass, system.stiffness, bodies_of(system), 12).shapes[:, 3:]
    highest = 1.01 * dense(stiffer)[14]
    cold, warm = (
        lowest_below(stiffer.mass, stiffer.stiffness, bodies, highest, start) for start in (None, near)
    )
    # iterated for to 1e-12 of the inverse's eigenvalue, and rounding of the factors, 1e-16 times 1e5
    np.testing.assert_allclose(warm.squares, cold.squares, rtol=1e-10)


def test_modes_that_rounding_hides_are_refused() -> None:
    # (0.4 m/1e-5 m)^2 and (40 mm/1e-5 m)^2 between shear and bending: 1e17 in all
    foil = square_plate(1e-5)
    with pytest.raises(StructureError, match="rounding hides"):
        lowest_first(foil.mass, foil.stiffness, bodies_of(foil), 4)


@pytest.mark.parametrize(
    ("message", "expected"),
    [("SUPERLU_MALLOC fails for buf in intCalloc()", MemoryError), ("Factor is singular", RuntimeError)],
)
def test_a_factorisation_without_memory_says_so(
    monkeypatch: pytest.MonkeyPatch, message: str, expected: type[Exception]
) -> None:
    """The modes of a large plate were answered by a 500."""

    def failing(*_: object, **__: object) -> None:
        raise RuntimeError(message)

    monkeypatch.setattr(lowest_modes, "splu", failing)
    with pytest.raises(expected):
        lowest_modes.factorised(csc_array(np.eye(2)))

"""Shear and rotary inertia: a free beam's exact frequencies, and the first-order fall of a pinned one's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from modallab.core.arrays import FloatArray
from modallab.core.place import Members, Place
from modallab.effects.shear_and_rotary_inertia import ShearAndRotaryInertia
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import Support
from modallab.rig.setup import AcquisitionRun
from tests.rigs import BAR, STEEL, dofs, steel_beam

SHOT = AcquisitionRun(dofs(1), dofs(1))
N = 100


def free_exactly(amount: float, near: FloatArray) -> FloatArray:
    """Hz, frequencies of the free beam below `near`, from the transfer matrix of (w, psi, M, V)."""
    shear = BAR.shear_coefficient * BAR.area * STEEL.shear_modulus
    bend = STEEL.modulus * BAR.second_moment
    m, j = STEEL.density * BAR.area, STEEL.density * BAR.second_moment

    def unbalanced(frequency: float) -> float:
        square = (2 * np.pi * frequency) ** 2
        along = np.array(
            [
                [0, 1, 0, amount / shear],
                [0, 0, 1 / bend, 0],
                [0, -amount * j * square, 0, -1],
                [-m * square, 0, 0, 0],
            ]
        )
        return float(np.linalg.det(expm(1.5 * along)[2:, :2]))

    return np.array([brentq(unbalanced, 0.9 * f, 1.001 * f, xtol=1e-9) for f in near])


@pytest.mark.parametrize("amount", [0.5, 1.0, 3.0, 10.0])
def test_frequencies_fall_as_those_of_the_exact_free_beam(amount: float) -> None:
    system = assemble(steel_beam(n_elements=N))
    bare = system.modes().elastic(8).frequencies
    found = ShearAndRotaryInertia(amount=amount).on_system(system, SHOT).modes().elastic(8).frequencies
    wanted = free_exactly(amount, bare)
    assert wanted[-1] < (1 - 0.004 * amount) * bare[-1]  # well above the error of the elements
    # Cubic elements err by (beta h)^4 / 1440 = 4e-6 at the eighth mode; even shear by (beta h)^2 / 24 of
    # its share of the energy, beta^2 E I / kappa A G: 2.4e-5, and a third more from rotary inertia.
    np.testing.assert_allclose(found, wanted, rtol=4e-6 + 3.2e-5 * amount)


def test_a_slender_pinned_beam_falls_to_first_order_as_timoshenko_says() -> None:
    n = 60
    held = (Support(1, ("Y",)), Support(n + 1, ("Y",)))
    system = assemble(beam(length=1.5, n_elements=n, section=BAR, material=STEEL, supports=held))
    bare, found = (
        s.modes().elastic(6).frequencies for s in (system, ShearAndRotaryInertia().on_system(system, SHOT))
    )
    # Timoshenko (1921): (n pi r / L)^2 (1 + E / kappa G) / 2; the next order is of the same size squared
    square = (np.arange(1, 7) * np.pi / 1.5) ** 2 * BAR.second_moment / BAR.area
    ratio = STEEL.modulus / (BAR.shear_coefficient * STEEL.shear_modulus)
    np.testing.assert_allclose(1 - found / bare, square * (1 + ratio) / 2, rtol=0.02)


@pytest.mark.parametrize("at", [None, Members((3, 4, 5))])
def test_a_share_of_it_lies_between_and_stays_in_the_model(at: Place) -> None:
    structure = steel_beam()
    bare = assemble(structure).modes().elastic(8).frequencies
    half, full = (
        ShearAndRotaryInertia(at, amount).on_system(assemble(structure), SHOT).modes().elastic(8).frequencies
        for amount in (0.5, 1.0)
    )
    assert (full < half).all()
    assert (half < bare).all()
    assert ShearAndRotaryInertia(at, 0.5).added_to(structure).effects == (
        ShearAndRotaryInertia(at, 0.5).spec,
    )
    turned = ShearAndRotaryInertia(at).added_to(structure)
    assert {m.number for m in turned.members if m.element == "timoshenko"} == set(
        range(1, 21) if at is None else (3, 4, 5)
    )


def test_members_that_have_it_gain_nothing() -> None:
    structure = steel_beam()
    his = replace(structure, members=tuple(replace(m, element="timoshenko") for m in structure.members))
    system = assemble(his)
    found = ShearAndRotaryInertia().on_system(system, SHOT)
    np.testing.assert_array_equal(found.stiffness.toarray(), system.stiffness.toarray())
    np.testing.assert_array_equal(found.mass.toarray(), system.mass.toarray())


def test_the_members_of_a_variant_are_solved_for_once() -> None:
    system, effect = assemble(steel_beam()), ShearAndRotaryInertia(amount=0.7)
    one, other = (effect.on_system(s, SHOT) for s in (system, system.add_mass(3, 0.1)))
    assert one.base_modes(800.0) is other.base_modes(800.0)

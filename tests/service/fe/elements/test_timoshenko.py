"""The Timoshenko element against the exact solutions of Timoshenko's differential equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.element import ELEMENTS, Bar
from modallab.fe.structure import Material, Section, Structure, Support

# A stout bar: 1 m long, 50 mm wide, 150 mm high; bending modes shear nearly as much as they bend.
SECTION = Section(area=7.5e-3, second_moment=1.40625e-5)
STEEL = Material(modulus=2.1e11, density=7800.0, poisson_ratio=0.3)


def structure(n: int, *, pinned: bool = False, element: str = "timoshenko") -> Structure:
    supports = (Support(1, ("Y",)), Support(n + 1, ("Y",))) if pinned else ()
    return beam(length=1.0, n_elements=n, section=SECTION, material=STEEL, element=element, supports=supports)


def frequencies(made: Structure, count: int) -> FloatArray:
    return assemble(made).modes().elastic(count).frequencies


def pinned_exactly(count: int) -> FloatArray:
    """Hz, the first branch for w = sin(n pi x / L), psi = cos(n pi x / L): det(K - omega^2 M) = 0.

    Huang, Journal of Applied Mechanics 28 (1961) 579-584, hinged-hinged.
    """
    k = np.arange(1, count + 1) * np.pi
    shear = SECTION.shear_coefficient * SECTION.area * STEEL.shear_modulus
    bend = STEEL.modulus * SECTION.second_moment
    m, j = STEEL.density * SECTION.area, STEEL.density * SECTION.second_moment
    a, b, c = m * j, -(m * (bend * k**2 + shear) + j * shear * k**2), shear * bend * k**4
    return np.asarray(np.sqrt((-b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)) / (2 * np.pi))


def free_exactly(count: int) -> FloatArray:
    """Hz, from the transfer matrix of (w, psi, M, V) over the length: both ends without moment and shear."""
    shear = SECTION.shear_coefficient * SECTION.area * STEEL.shear_modulus
    bend = STEEL.modulus * SECTION.second_moment
    m, j = STEEL.density * SECTION.area, STEEL.density * SECTION.second_moment

    def unbalanced(frequency: float) -> float:
        square = (2 * np.pi * frequency) ** 2
        # w' = psi + V / (kappa A G), psi' = M / (E I), M' = -V - rho I w^2 psi, V' = -rho A w^2 w
        along = np.array(
            [[0, 1, 0, 1 / shear], [0, 0, 1 / bend, 0], [0, -j * square, 0, -1], [-m * square, 0, 0, 0]]
        )
        return float(np.linalg.det(expm(along)[2:, :2]))

    grid = np.linspace(50.0, 12000.0, 600)
    values = [unbalanced(f) for f in grid]
    signs = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0]
    return np.array([brentq(unbalanced, grid[i], grid[i + 1]) for i in signs[:count]])


def test_a_pinned_beam_has_the_frequencies_of_the_characteristic_equation() -> None:
    # The stout beam is far from Bernoulli and Euler: 31 % below them at the fourth mode.
    bernoulli = (np.arange(1, 5) * np.pi) ** 2 * np.sqrt(
        STEEL.modulus * SECTION.second_moment / (STEEL.density * SECTION.area)
    )
    assert pinned_exactly(4)[3] < 0.7 * bernoulli[3] / (2 * np.pi)
    # each element shears evenly: of 120, mode 4 is at most (k h)^2 / 24 = 4.6e-4 too high
    np.testing.assert_allclose(frequencies(structure(120, pinned=True), 4), pinned_exactly(4), rtol=4.6e-4)


def test_a_free_beam_has_the_frequencies_of_the_exact_transfer_matrix() -> None:
    # (k h)^2 / 24 of mode 5, k near 5.5 pi
    np.testing.assert_allclose(frequencies(structure(120), 5), free_exactly(5), rtol=8.7e-4)


@pytest.mark.parametrize("pinned", [True, False])
def test_frequencies_converge_from_above_with_the_square_of_the_length_of_an_element(pinned: bool) -> None:
    exact = (pinned_exactly if pinned else free_exactly)(3)
    coarse, fine = (frequencies(structure(n, pinned=pinned), 3) / exact - 1 for n in (16, 32))
    assert (fine > 0).all()  # a displacement element is too stiff
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.04)  # bending adds a fourth power


def test_frequencies_err_by_what_an_even_shear_in_each_element_leaves_out() -> None:
    n, k = 64, np.arange(1, 4) * np.pi
    exact = pinned_exactly(3)
    shear = SECTION.shear_coefficient * SECTION.area * STEEL.shear_modulus
    turned = k - STEEL.density * SECTION.area * (2 * np.pi * exact) ** 2 / (shear * k)  # psi over w
    # In an element shear is even and drives the slope of the moment alone: of the shear k gamma sin and
    # of the moment's slope from rotary inertia, rho I omega^2 psi, a straight line's h^2 / 12 is lost.
    bend, gamma = STEEL.modulus * SECTION.second_moment, k - turned
    inertia = STEEL.density * SECTION.second_moment * (2 * np.pi * exact) ** 2 * turned
    energy = shear * gamma**2 + bend * (k * turned) ** 2
    lost = (shear * (k * gamma) ** 2 + inertia**2 / bend) / (12 * n**2)
    error = frequencies(structure(n, pinned=True), 3) / exact - 1
    np.testing.assert_allclose(error, lost / energy / 2, rtol=0.01)


def test_what_does_not_shear_and_has_thin_sections_is_the_element_of_bernoulli_and_euler() -> None:
    bar = Bar(0.3, SECTION.area, SECTION.second_moment, STEEL.modulus, STEEL.density)
    ours, plain = ELEMENTS["timoshenko"](bar), ELEMENTS["frame"](bar)
    for part in ("axial", "bending"):
        np.testing.assert_allclose(ours.stiffness[part], plain.stiffness[part], rtol=1e-14)
    thin = replace(bar, second_moment=1e-20)  # bends all the same: its mass is looked at
    expected = ELEMENTS["frame"](thin).mass
    np.testing.assert_allclose(
        ELEMENTS["timoshenko"](thin).mass, expected, rtol=0, atol=1e-14 * np.abs(expected).max()
    )


def test_an_element_bends_under_an_end_load_as_the_textbook_says() -> None:
    bar = Bar(0.3, 7.5e-3, 1.4e-5, 2.1e11, 7800.0, shear_modulus=8e10, shear_coefficient=0.8)
    clamped = ELEMENTS["timoshenko"](bar).stiffness["bending"][np.ix_([4, 5], [4, 5])]
    tip = np.linalg.solve(clamped, [1.0, 0.0])[0]
    # Timoshenko, Strength of Materials: P L^3 / 3 E I + P L / kappa A G; exact for this element
    expected = 0.3**3 / (3 * 2.1e11 * 1.4e-5) + 0.3 / (0.8 * 7.5e-3 * 8e10)
    assert tip == pytest.approx(expected, rel=1e-12)

"""Receptances of variants together are those of each alone, and the direct solution."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.receptance import attached, direct_receptance
from modallab.fe.variants import attached_variants

FREQ = np.array([3.0, 17.0, 61.0, 240.0, 800.0])


@pytest.mark.parametrize("unlike", [False, True], ids=["of one width", "of several widths"])
def test_variants_together_are_the_variants_one_by_one(unlike: bool) -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]()).add_mass(1, 0.01).change_member(7, bending=0.3)
    variants = [system.add_mass(node, 0.02) for node in (1, 9, 21)]
    if unlike:
        variants[1] = variants[1].change_member(3, mass=0.1)
    lefts = [system.selection((Dof(node, "Y"),)) for node in (1, 9, 21)]
    right = system.selection((Dof(1, "Y"),))
    response = system.base_modes(800.0).at(2 * np.pi * FREQ)
    together = attached_variants(variants, 2 * np.pi * FREQ, lefts, [right] * len(variants))
    apart = [attached(response, v, left, right) for v, left in zip(variants, lefts, strict=True)]
    np.testing.assert_allclose(together, apart, rtol=1e-9)  # the same equations in another order


@pytest.mark.parametrize("first", [0, 1], ids=["it comes first", "it comes last"])
def test_a_variant_may_carry_again_what_all_carry(first: int) -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]()).add_mass(1, 0.02)
    both = (system.add_mass(1, 0.02).add_mass(5, 0.01), system.add_mass(5, 0.03))
    variants = [both[first], both[1 - first]]
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    found = attached_variants(variants, 2 * np.pi * FREQ, [at, at], [at, at])
    wanted = [direct_receptance(variant, FREQ, at, at) for variant in variants]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)  # rounding, at antiresonances


def test_masses_in_one_place_are_one_mass() -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    nodes, omega = (5, 9), 2 * np.pi * FREQ
    twice = [system.add_mass(node, 0.02).add_mass(node, 0.01) for node in nodes]
    at = [system.selection((Dof(node, "Y"), Dof(1, "Y"))) for node in nodes]
    found = attached_variants(twice, omega, at, at)
    once = attached_variants([system.add_mass(node, 0.03) for node in nodes], omega, at, at)
    np.testing.assert_allclose(found, once, rtol=1e-12)  # the same equations
    wanted = [direct_receptance(variant, FREQ, a, a) for variant, a in zip(twice, at, strict=True)]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)  # as above

"""Uniform beams against the roots of their characteristic equations."""

import numpy as np
import pytest

from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import Material, Section, Support
from tests.published.tables import table

ROOTS = table("beams_blevins")
CASES = [name for name, case in ROOTS.items() if isinstance(case, dict)]


@pytest.mark.parametrize("name", CASES)
def test_beam_roots_match_the_published_table(name: str) -> None:
    case, n = ROOTS[name], 24
    supports = (Support(1, tuple(case["held_left"])), Support(n + 1, tuple(case["held_right"])))
    structure = beam(
        length=1.0,
        n_elements=n,
        section=Section(area=1.0, second_moment=1.0),
        material=Material(modulus=1.0, density=1.0),
        supports=supports,
    )
    # with E I = rho A = L = 1 the eigenvalue is (beta L)^4
    found = assemble(structure).modes().elastic(len(case["beta_l"])).eigenvalues.real ** 0.25
    np.testing.assert_allclose(found, case["beta_l"], rtol=5e-6)

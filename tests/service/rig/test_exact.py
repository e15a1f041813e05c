"""FRFs of a structure without a rig."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.rig.exact import exact_frf
from tests.rigs import beam_system, dofs, steel_beam


def test_it_is_the_inertance_of_the_equations_of_motion() -> None:
    frf = exact_frf(steel_beam(), dofs(1)[0], dofs(1, 11), frequency_max=800.0, n_lines=81)
    assert (frf.kind, frf.outputs, frf.inputs) == (FrfKind.INERTANCE, dofs(1, 11), dofs(1))
    system = beam_system()
    alpha = direct_receptance(system, frf.freq[1:], system.selection(dofs(1, 11)), system.selection(dofs(1)))
    exact = -((2 * np.pi * frf.freq[1:, None, None]) ** 2) * alpha
    # solved line by line against a sum of modes: rounding, most beside what cancels in antiresonances
    np.testing.assert_allclose(frf.values[1:], exact, rtol=1e-7, atol=1e-8 * np.abs(exact).max())


def test_at_rest_a_free_body_moves_as_a_rigid_one() -> None:
    damping = StructuralDamping(stiffness_coefficient=0.005)
    frf = exact_frf(steel_beam(damping), dofs(1)[0], dofs(1), frequency_max=80.0, n_lines=801)
    mass = 7800.0 * 5e-4 * 1.5
    # a rod pushed at its end: 1/m + (l/2)^2/(m l^2/12). A thousandth of a line stands for 0 Hz, where
    # rounding of the rigid bodies' loss over omega^2 is 3e-6
    assert frf.values[0, 0, 0] == pytest.approx(4 / mass, rel=1e-5)


def test_too_many_lines_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="n_lines"):
        exact_frf(steel_beam(), dofs(1)[0], dofs(1), frequency_max=800.0, n_lines=1_000_001)

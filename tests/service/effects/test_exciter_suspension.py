"""Against a rigid block that a suspended armature pushes, in closed form."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.exciter_suspension import ExciterSuspension
from modallab.rig.chain import chain
from modallab.rig.hardware import Exciter
from modallab.rig.setup import RigSetup
from tests.shakers import block

MASS, ARMATURE, STIFFNESS, DAMPING = 1.0, 0.2, 2e4, 5.0
SETUP = RigSetup((Dof(1, "X"),), (Dof(1, "X"),))
FREQ = np.linspace(1.0, 200.0, 400)
EFFECTS = [ExciterArmature(mass=ARMATURE), ExciterSuspension(stiffness=STIFFNESS, damping=DAMPING)]


def test_a_block_gets_the_share_of_the_force_that_its_inertia_has_in_the_whole() -> None:
    omega = 2 * np.pi * FREQ
    whole = STIFFNESS + 1j * omega * DAMPING - (MASS + ARMATURE) * omega**2
    found = chain(block(MASS), SETUP, EFFECTS).respond(FREQ).force[0, :, 0, 0]
    np.testing.assert_allclose(
        found, -MASS * omega**2 / whole, rtol=1e-4
    )  # rigid to 1e-5, where spring and inertia cancel down to 3e-2


def test_the_suspension_makes_the_spectra_peak_where_block_and_armature_swing_on_it() -> None:
    frequency, half = (values[0, 0] for values in chain(block(MASS), SETUP, EFFECTS).poles())
    total = MASS + ARMATURE
    assert frequency == pytest.approx(np.sqrt(STIFFNESS / total) / (2 * np.pi), rel=1e-4)  # rigid, as above
    assert half == pytest.approx(DAMPING / total / (4 * np.pi), rel=1e-4)


def test_the_log_book_declares_it() -> None:
    hardware = Exciter(armature_mass=ARMATURE, suspension_stiffness=STIFFNESS, suspension_damping=DAMPING)
    declared = chain(block(MASS), RigSetup((Dof(1, "X"),), (Dof(1, "X"),), hardware)).respond(FREQ)
    np.testing.assert_array_equal(declared.force, chain(block(MASS), SETUP, EFFECTS).respond(FREQ).force)

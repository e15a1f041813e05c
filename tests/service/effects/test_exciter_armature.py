"""Against a rigid block on a spring, in closed form."""

import numpy as np

from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.rig.chain import chain
from modallab.rig.setup import RigSetup
from tests.shakers import block

MASS, STIFFNESS, ARMATURE = 2.0, 2e6, 0.1
SETUP = RigSetup((Dof(1, "X"),), (Dof(1, "X"),))
FREQ = np.linspace(5.0, 400.0, 4000)


def test_the_force_falls_as_the_armature_needs_it_and_the_frf_stays() -> None:
    bare, loaded = (
        chain(block(MASS, STIFFNESS), SETUP, effects).respond(FREQ)
        for effects in ([], [ExciterArmature(mass=ARMATURE)])
    )
    omega = 2 * np.pi * FREQ
    wanted = 1 / (1 - ARMATURE * omega**2 / (STIFFNESS - MASS * omega**2))
    # the block is rigid to 3e-5, of a spring and an inertia that cancel down to 1e-2 of themselves
    far = np.abs(STIFFNESS - MASS * omega**2) > 1e-2 * STIFFNESS
    far &= np.abs(STIFFNESS - (MASS + ARMATURE) * omega**2) > 1e-2 * STIFFNESS
    np.testing.assert_allclose(loaded.force[0, far, 0, 0], wanted[far], rtol=3e-3)
    np.testing.assert_allclose(loaded.inertance, bare.inertance, rtol=1e-12)  # rounding


def test_what_the_source_feels_resonates_lower_by_the_root_of_the_masses() -> None:
    own = np.sqrt(STIFFNESS / MASS) / (2 * np.pi)
    found = chain(block(MASS, STIFFNESS), SETUP, [ExciterArmature(mass=ARMATURE)]).poles()[0][0, 0]
    # rigid to 1e-5
    np.testing.assert_allclose(found, own * np.sqrt(MASS / (MASS + ARMATURE)), rtol=1e-5)

"""Against a block that carries the mass, its force corrected by hand."""

import numpy as np

from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.force_transducer_stiffness import ForceTransducerStiffness
from modallab.rig.chain import chain
from modallab.rig.hardware import Exciter, ForceTransducer
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs

FREQ = np.linspace(3.0, 800.0, 200)
MASS = 0.05
SETUP = RigSetup(dofs(1), dofs(1, 7), Exciter(armature_mass=0.1))


def test_what_is_shown_is_the_gauge_s_force_less_mass_times_acceleration() -> None:
    gauge = ForceTransducer(MASS, mass_cancelled=True, stiffness=4e5)
    shown = chain(
        beam_system(), RigSetup(dofs(1), dofs(1, 7), Exciter(armature_mass=0.1), force_transducer=gauge)
    ).respond(FREQ)
    loaded = beam_system().add_mass(1, MASS)
    felt = chain(loaded, SETUP, [ForceTransducerStiffness(stiffness=4e5)]).respond(FREQ)
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    corrected = felt.force[..., 0] - MASS * felt.response[:, :, 0]
    np.testing.assert_allclose(shown.force[..., 0], corrected, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(shown.response, felt.response, rtol=1e-7, atol=1e-9 * 20)


def test_rigidly_joined_it_is_a_heavier_armature() -> None:
    gauge = ForceTransducer(MASS, mass_cancelled=True)
    shown = chain(
        beam_system(), RigSetup(dofs(1), dofs(1, 7), Exciter(armature_mass=0.1), force_transducer=gauge)
    ).respond(FREQ)
    heavier = chain(beam_system(), RigSetup(dofs(1), dofs(1, 7)), [ExciterArmature(mass=0.1 + MASS)])
    np.testing.assert_allclose(shown.force, heavier.respond(FREQ).force, rtol=1e-12)  # rounding

"""Mass loading by accelerometers, held against rigid bodies and the continuous beam."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import GroundSpringElement, Section, Support
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests import bernoulli
from tests.rigs import STEEL, beam_system, dofs, rig

CENTRE = Dof(2, "Y")
STIFFNESS, MASS = 1e4, 7800.0 * 4e-4 * 0.06  # N/m, kg


def block() -> DynamicSystem:
    """A bar three times as long as high, on a spring, that cannot turn: it bends at 30 kHz."""
    thick = Section(area=4e-4, second_moment=0.02**4 / 12)
    held, spring = (Support(2, ("RZ",)),), (GroundSpringElement(CENTRE, STIFFNESS),)
    return assemble(
        beam(length=0.06, n_elements=2, section=thick, material=STEEL, supports=held, springs=spring)
    )


@pytest.mark.parametrize("mass", [0.01, 0.1, 0.5])
def test_a_rigid_mass_on_a_spring_falls_by_the_root_of_the_masses(mass: float) -> None:
    """f sqrt(m / (m + m_a)): Ewins, Modal Testing (2000), section 3.7."""
    setup = RigSetup((CENTRE,), (CENTRE,), accelerometers=Accelerometers(mass))
    bare, loaded = (chain(block(), one).poles()[0][0, 0] for one in (RigSetup((CENTRE,), (CENTRE,)), setup))
    # The block bends by (37 Hz / 30 kHz)^2 = 2e-6 of its motion.
    assert bare == pytest.approx(np.sqrt(STIFFNESS / MASS) / (2 * np.pi), rel=1e-5)
    assert loaded / bare == pytest.approx(np.sqrt(MASS / (MASS + mass)), rel=1e-5)


def test_the_frf_is_that_of_the_heavier_mass_and_two_accelerometers_weigh_twice() -> None:
    freq = np.array([5.0, 20.0, 60.0, 150.0])
    omega2 = (2 * np.pi * freq) ** 2
    for outputs in ((CENTRE,), dofs(1, 3)):
        setup = RigSetup((CENTRE,), outputs, accelerometers=Accelerometers(0.05))
        found = chain(block(), setup).respond(freq).inertance[0, ..., 0]
        wanted = -omega2 / (STIFFNESS - omega2 * (MASS + 0.05 * len(outputs)))
        # Its ends bend by (150 Hz / 20 kHz)^2 = 6e-5, the heaviest case at the highest frequency.
        np.testing.assert_allclose(found, np.broadcast_to(wanted[:, None], found.shape), rtol=1e-4)


def test_of_a_roving_accelerometer_every_run_shifts_each_mode_by_half_of_mass_times_motion_squared() -> None:
    mass, nodes = 1e-4, (2, 6, 9, 15, 21)
    setup = rig(*nodes, accelerometers=Accelerometers(mass, roving=True))
    bare = chain(beam_system(), rig(*nodes)).poles()[0][0, :6]
    found = chain(beam_system(), setup).poles()[0][:, :6] / bare - 1
    there = bernoulli.shapes([bernoulli.place(node) for node in nodes]) ** 2 / bernoulli.MASS
    # The next order is a few times m phi^2, 7e-5, of the greatest shift. At the ends the sixth shape of
    # twenty elements has a square 2.4e-3 too large, which falls as (z/20)^4, z = 20.4 the wave number.
    np.testing.assert_allclose(found, -mass * there.T / 2, rtol=0, atol=3e-3 * np.abs(found).max())


def test_one_that_stays_at_a_dof_loads_every_run_alike() -> None:
    mass = 1e-4
    setup = rig(1, 6, 16, accelerometers=Accelerometers(roving=True))
    bare, found = (
        chain(beam_system(), setup, added).poles()[0][:, :6]
        for added in ((), (AccelerometerMass(at=Dof(21, "Y"), mass=mass),))
    )
    # At a free end every mode moves alike: phi^2 = 4/M. Next order and elements as above.
    np.testing.assert_allclose(found / bare - 1, -2 * mass / bernoulli.MASS, rtol=3e-3)

"""What sits below the sensing element of a force gauge, held against rigid bodies and one more impedance."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers, ForceTransducer
from modallab.rig.setup import RigSetup
from tests import bernoulli, oscillator
from tests.rigs import beam_system, dofs, rig

FREQ = np.linspace(5.0, 800.0, 60)
BARE = bernoulli.inertance(*bernoulli.matrices({}, {}), FREQ, (1, 7, 16))


def near(found: ComplexArray, wanted: ComplexArray) -> None:
    """Equal up to the rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6."""
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("mass", [0.01, 0.2])
def test_a_mass_on_a_spring_falls_by_the_root_of_the_masses(mass: float) -> None:
    setup = oscillator.rig_at_tip()
    found = chain(oscillator.system(), setup, [ForceTransducerMass(mass=mass)]).poles()[0][0, 0]
    lowered = oscillator.FREQUENCY * np.sqrt(oscillator.MASS / (oscillator.MASS + mass))
    assert found == pytest.approx(lowered, rel=1e-9)  # closed form: rounding


@pytest.mark.parametrize("roving", [False, True])
def test_every_frf_of_every_run_is_divided_by_the_same_number(roving: bool) -> None:
    """The gauge shows F' = F + m a: H'_j = H_j / (1 + m H_drive), 1992 thesis, section 5.4.1."""
    mass = 0.05
    setup = rig(
        1,
        7,
        16,
        force_transducer=ForceTransducer(mass_below=mass),
        accelerometers=Accelerometers(roving=roving),
    )
    bench = chain(beam_system(), setup)
    assert len(bench.runs) == (3 if roving else 1)
    found = bench.respond(FREQ).inertance[..., 0]
    by_output = found[:, :, 0].T if roving else found[0]
    near(by_output, BARE / (1 + mass * BARE[:, :1]))
    frequencies, _ = bench.poles()
    np.testing.assert_allclose(frequencies, frequencies[:1].repeat(len(frequencies), axis=0), rtol=1e-12)


def test_a_small_one_at_a_free_end_lowers_all_modes_by_the_same_share() -> None:
    mass = 1e-4
    bare, found = (
        chain(beam_system(), rig(7), added).poles()[0][0, :6]
        for added in ((), (ForceTransducerMass(mass=mass),))
    )
    # phi^2 = 4/M at the end of a free beam, whatever the mode. The next order is a few times m phi^2, 7e-5;
    # the sixth shape of twenty elements is 2.4e-3 too large there, which falls as (z/20)^4, z = 20.4.
    np.testing.assert_allclose(found / bare - 1, -2 * mass / bernoulli.MASS, rtol=3e-3)


def test_cancelled_it_leaves_every_frf() -> None:
    setup = rig(1, 7, 16, force_transducer=ForceTransducer(mass_below=0.05, mass_cancelled=True))
    bench = chain(beam_system(), setup)
    assert not [effect for effect in bench.effects if isinstance(effect, ForceTransducerMass)]
    near(bench.respond(FREQ).inertance[0, ..., 0], BARE)


def test_of_two_gauges_the_one_named_is_heavy() -> None:
    system, setup = beam_system(), RigSetup(dofs(1, 21), dofs(7))
    named = chain(system, setup, [ForceTransducerMass(at=Dof(21, "Y"), mass=0.05)])
    both = chain(system, setup, [ForceTransducerMass(mass=0.05)])
    by_hand = {1: 0.05, 21: 0.05}
    for bench, nodes in ((named, (21,)), (both, (1, 21))):
        mass, stiffness = bernoulli.matrices({}, {})
        omega = 2 * np.pi * FREQ[:, None, None]
        damped = 1j * (100.0 * mass + 0.005 * stiffness)
        for node in nodes:
            mass[2 * node - 2, 2 * node - 2] += by_hand[node]
        alpha = np.linalg.inv(stiffness + damped - omega**2 * mass)[:, 12, [0, 40]]
        near(bench.respond(FREQ).inertance[0, :, 0], -(omega[:, 0] ** 2) * alpha)

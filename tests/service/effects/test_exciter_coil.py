"""Against the circuit that a shaker is from its terminals, in closed form."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.exciter_coil import ExciterCoil
from modallab.effects.exciter_suspension import ExciterSuspension
from modallab.rig.chain import chain
from modallab.rig.hardware import Coil, Exciter
from modallab.rig.setup import RigSetup
from tests.shakers import block

MASS, ARMATURE, STIFFNESS, DAMPING = 0.5, 0.05, 1e4, 2.0
FACTOR, RESISTANCE, INDUCTANCE = 9.0, 2.5, 8e-4
HERE = (Dof(1, "X"),)
FREQ = np.linspace(1.0, 800.0, 400)


def force(exciter: Exciter) -> object:
    return chain(block(MASS), RigSetup(HERE, HERE, exciter)).respond(FREQ).force[0, :, 0, 0]


def test_the_current_is_that_of_a_resonant_circuit() -> None:
    """From the terminals masses are a capacity m/BL^2, the spring an inductance BL^2/k, the damper a
    conductance c/BL^2, all in parallel, behind R and L."""
    omega = 2 * np.pi * FREQ
    capacity, spring = (MASS + ARMATURE) / FACTOR**2, FACTOR**2 / STIFFNESS
    parallel = 1j * omega * capacity + 1 / (1j * omega * spring) + DAMPING / FACTOR**2
    terminals = RESISTANCE + 1j * omega * INDUCTANCE + 1 / parallel
    voltage = RESISTANCE / FACTOR  # tells 1 N
    velocity = voltage / terminals / parallel / FACTOR
    wanted = 1j * omega * MASS * velocity  # force that moves the block
    coil = ExciterCoil(force_factor=FACTOR, resistance=RESISTANCE, inductance=INDUCTANCE)
    effects = [
        ExciterArmature(mass=ARMATURE),
        ExciterSuspension(stiffness=STIFFNESS, damping=DAMPING),
        coil,
    ]
    found = chain(block(MASS), RigSetup(HERE, HERE), effects).respond(FREQ).force[0, :, 0, 0]
    np.testing.assert_allclose(found, wanted, rtol=1e-3)  # the block is rigid to 1e-4


def test_a_kept_voltage_damps_and_a_kept_current_does_not() -> None:
    parts = {"armature_mass": ARMATURE, "suspension_stiffness": STIFFNESS, "suspension_damping": DAMPING}
    coil = Coil(FACTOR, RESISTANCE)
    rigs = [
        RigSetup(HERE, HERE, Exciter(**parts, coil=coil, amplifier=amplifier))  # type: ignore[arg-type]
        for amplifier in ("current", "voltage")
    ]
    current, voltage = (chain(block(MASS), setup).poles()[1][0, 0] for setup in rigs)
    per_viscous = 1 / (4 * np.pi * (MASS + ARMATURE))  # half bandwidth, Hz, of an N s/m
    assert current == pytest.approx(DAMPING * per_viscous, rel=1e-4)  # rigid, as above
    assert voltage == pytest.approx((DAMPING + FACTOR**2 / RESISTANCE) * per_viscous, rel=1e-4)


def test_with_a_kept_current_the_coil_makes_no_difference() -> None:
    with_coil = Exciter(armature_mass=ARMATURE, coil=Coil(FACTOR, RESISTANCE, INDUCTANCE))
    np.testing.assert_array_equal(force(with_coil), force(Exciter(armature_mass=ARMATURE)))


def test_a_kept_voltage_needs_a_coil() -> None:
    with pytest.raises(InvalidInputError, match="coil") as caught:
        Exciter(amplifier="voltage")
    assert caught.value.context["field"] == "exciter.coil"

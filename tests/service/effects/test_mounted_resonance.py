"""An accelerometer rings on what holds it."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.effects.mounted_resonance import MountedResonance
from modallab.fe.assembly import assemble
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, tilted_beam

SETUP = rig(1, 7, 16)


@pytest.mark.parametrize("loss", [0.01, 0.3])
@pytest.mark.parametrize("mass", [0.0, 0.05])
def test_it_reads_and_loads_as_a_mass_on_its_spring(loss: float, mass: float) -> None:
    """The finer model: a mass on spring and dashpot at 7:+Y, solved with the beam line by line."""
    natural, on_spring = 2 * np.pi * 600.0, mass or 1e-7  # rad/s; kg, too light to load the beam
    freq = np.linspace(10.0, 800.0, 80)
    w = 2 * np.pi * freq[:, None, None]
    system = beam_system()
    assert system.damping is not None
    matrices = (np.pad(part.toarray(), (0, 1)) for part in (system.mass, system.stiffness, system.damping))
    inertia, stiffness, damping = matrices
    strain = np.append(-system.selection(dofs(7)), 1.0)
    held = on_spring * np.outer(strain, strain)
    inertia[-1, -1] = on_spring
    z = stiffness + 1j * damping - w**2 * inertia + (natural**2 + 1j * w * loss * natural) * held
    force = np.append(system.selection(dofs(1)), 0.0)
    wanted = -(w[:, 0, 0] ** 2) * np.linalg.solve(z, force[None, :, None])[:, -1, 0]
    effect = MountedResonance(at=Channels(dofs(7)), frequency=600.0, loss=loss)
    setup = rig(1, 7, accelerometers=Accelerometers(mass=mass, roving=True))
    found = chain(system, setup, [effect]).respond(freq).inertance[1, :, 0, 0]
    # 1e-7 kg on a beam of 5.85 kg, times 100 where it rings and 100 where the beam does
    np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-5 * np.abs(wanted).max())


@pytest.mark.parametrize(("part", "percent"), [(3, 12.5), (5, 4.1667)])
def test_at_a_third_it_reads_an_eighth_too_high_and_at_a_fifth_a_twenty_fourth(
    part: int, percent: float
) -> None:
    """1/(1 - 1/9) and 1/(1 - 1/25): what the rules of thumb call 10 % and 5 %."""
    pair: tuple[list[Effect], ...] = [], [MountedResonance(frequency=part * 400.0, loss=1e-3)]
    bare, found = (chain(beam_system(), SETUP, e).respond(np.array([400.0])).inertance for e in pair)
    # a loss of 1e-3 takes (1e-3/3)^2/2 of it
    np.testing.assert_allclose(100 * (np.abs(found / bare) - 1), percent, rtol=1e-4)


@pytest.mark.parametrize(("mounting", "frequency"), [("stud", 31e3), ("wax", 29e3), ("magnet", 7e3)])
def test_declared_mountings_ring_where_handbooks_say(mounting: str, frequency: float) -> None:
    declared = rig(7, accelerometers=Accelerometers(mounting=mounting))  # type: ignore[arg-type]
    (effect,) = MountedResonance.from_setup(declared)
    assert effect.frequency == frequency
    given = rig(7, accelerometers=Accelerometers(mounting=mounting, mounted_frequency=9e3))  # type: ignore[arg-type]
    (other,) = MountedResonance.from_setup(given)
    assert (other.frequency, other.loss) == (9e3, effect.loss)


def test_a_mounted_frequency_alone_is_enough() -> None:
    (effect,) = MountedResonance.from_setup(rig(7, accelerometers=Accelerometers(mounted_frequency=4e3)))
    assert effect.frequency == 4e3


def across(transverse: float) -> FloatArray:
    """Return the magnitude of the FRF across a beam at a slope, over that of the beam laid level."""
    effect = MountedResonance(frequency=300.0, loss=0.1, transverse=transverse)
    freq, accelerometers = np.linspace(20.0, 400.0, 60), Accelerometers(mass=0.05, roving=True)
    responses = (Dof(7, "X"), Dof(7, "Y"))
    tilted = RigSetup(dofs(1), responses, accelerometers=accelerometers)
    by_axis = chain(assemble(tilted_beam()), tilted, [effect]).respond(freq).inertance[:, :, 0, 0]
    level = rig(7, accelerometers=accelerometers)
    # A force along Y is 0.8 of one across the beam; its motion has the axes -0.6 X and 0.8 Y.
    wanted = 0.8 * chain(beam_system(), level, [effect]).respond(freq).inertance[0, :, 0, 0]
    return np.asarray(np.abs((0.8 * by_axis[1] - 0.6 * by_axis[0]) / wanted))


def test_a_mounting_that_gives_way_in_all_directions_does_not_care_for_the_axis() -> None:
    np.testing.assert_allclose(across(1.0), 1.0, rtol=1e-6)  # rounding of modes
    assert np.abs(across(0.0) - 1).max() > 0.05


def test_a_beam_that_moves_across_alone_has_no_other_choice() -> None:
    assert MountedResonance().variants(beam_system()) == ()
    assert MountedResonance().variants(assemble(tilted_beam())) == (MountedResonance(transverse=1.0),)

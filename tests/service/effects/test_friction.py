"""Dry friction on a mass, held against the damper that it is to a Gaussian motion by closed form."""

import numpy as np
import pytest

from modallab.effects.friction import Friction
from modallab.estimation.coherence import coherence
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.setup import RigSetup
from tests import oscillator
from tests.oscillator import DAMPING, FREQUENCY, MASS, OMEGA, TIP

# The velocity lacks what the force has above the band, 4 zeta/pi f/f_max, 6e-4 of its mean square.
BEYOND = 1e-3


def periodic(level: float = 1.0, n_lines: int = 5401) -> RigSetup:
    """A rig whose lines, many to a half-power bandwidth, see what they see without a window."""
    return oscillator.rig_at_tip(level, "periodic_random", window="rectangular", n_lines=n_lines)


def velocity(setup: RigSetup, damping: float = DAMPING) -> float:
    """Root mean square velocity, m/s, of the mass under white force: s^2 = G/(4 c m)."""
    return float(np.sqrt(oscillator.density(setup) / (4 * damping * MASS)))


def damping(setup: RigSetup, friction: Friction) -> float:
    """Return the viscous damping, N s/m, of the oscillator with friction on it, from its half bandwidth."""
    frequencies, widths = chain(oscillator.system(), setup, [friction]).poles()
    assert frequencies[0, 0] == pytest.approx(FREQUENCY, rel=1e-9)  # a damper does not stiffen
    return float(4 * np.pi * MASS * widths[0, 0])


def rubbing(setup: RigSetup, force: float) -> Friction:
    """Friction that lets go at a thousandth of the motion's own velocity."""
    return Friction(TIP, force, 1e-3 * velocity(setup))


@pytest.mark.parametrize("setup", [oscillator.rig_at_tip(), periodic()], ids=["random", "periodic"])
def test_a_little_is_a_damper_of_its_force_over_the_mean_size_of_velocity(setup: RigSetup) -> None:
    """f_c sqrt(2/pi) / s_v: Booton (1954), IRE Trans. Circuit Theory 1, 9-18."""
    share = 1e-3
    force = share * DAMPING * velocity(setup) * np.sqrt(np.pi / 2)
    found = damping(setup, rubbing(setup, force)) - DAMPING
    # next order: half of the share; sticking takes less
    assert found == pytest.approx(share * DAMPING, rel=BEYOND + share / 2)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 5.0])
def test_much_of_it_slows_the_motion_and_so_damps_more(ratio: float) -> None:
    """c' = c + f_c sqrt(2/pi)/s', s' = s sqrt(c/c'): a quadratic equation in sqrt(c')."""
    setup = periodic()
    force = ratio * DAMPING * velocity(setup) * np.sqrt(np.pi / 2)
    root = (ratio + np.sqrt(ratio**2 + 4)) / 2  # of c'/c
    # what the velocity lacks goes with damping, and by half of it into the damper's share
    assert damping(setup, rubbing(setup, force)) == pytest.approx(DAMPING * root**2, rel=BEYOND * root**2)


def test_the_damping_that_it_adds_falls_as_one_over_the_level() -> None:
    levels = np.array([1.0, 2.0, 5.0, 20.0])
    friction = rubbing(periodic(), 0.02 * DAMPING * velocity(periodic()))
    added = np.array([damping(periodic(level), friction) for level in levels]) - DAMPING
    # half of the share, 2 % sqrt(2/pi), at the lowest level
    np.testing.assert_allclose(added * levels, added[-1] * levels[-1], rtol=0.01)


def test_motion_too_slow_to_let_go_has_a_damper_of_force_over_sticking_velocity() -> None:
    setup = periodic(n_lines=541)
    sticking = 100 * velocity(setup)
    friction = Friction(TIP, DAMPING * sticking, sticking)
    # tanh x = x - x^3/3: to x^2, 1e-4 of it
    assert damping(setup, friction) == pytest.approx(2 * DAMPING, rel=1e-4)


def test_coherence_drops_at_resonance_by_what_the_arcsine_law_leaves() -> None:
    """f_c^2 2/pi (arcsin rho - rho) with rho = e^(-a t) cos(w t): Van Vleck and Middleton (1966),
    Proc. IEEE 54, 2-19. It acts where the force does: coherence is one over one and its share of that."""
    setup, share = periodic(), 0.02
    force = share * DAMPING * velocity(setup) * np.sqrt(np.pi / 2)
    g2 = coherence(expected_spectra(chain(oscillator.system(), setup, [rubbing(setup, force)])))[0, :, 0]
    a = DAMPING * (1 + share) / (2 * MASS)
    t = np.arange(0, 12 / a, 2 * np.pi / OMEGA / 200)
    rho = np.exp(-a * t) * np.cos(OMEGA * t)
    left = force**2 * 2 / np.pi * (np.arcsin(rho) - rho) * np.cos(OMEGA * t)
    noise = 4 * np.trapezoid(left, t)  # one-sided
    density = oscillator.density(setup)
    at = round(FREQUENCY / setup.analyser.spacing)
    # The share is next order, half of it in force; the sine that comes with rho's cosine; the series of the
    # arcsine ends at 200 orders, 2 % of all that is left, most of that far from the resonance.
    assert 1 / g2[at] - 1 == pytest.approx(noise / density, rel=0.02)


def test_simulated_tests_are_of_friction_that_sticks_no_sooner_than_random_errors_tell() -> None:
    setup, system = periodic(), oscillator.system()
    usual = Friction(TIP, 0.5, 0.1 * velocity(setup))
    assert usual.smoothed(system, setup) is usual
    sharp = Friction(TIP, 0.5, 1e-7 * velocity(setup)).smoothed(system, setup)
    assert isinstance(sharp, Friction)
    assert sharp.force == 0.5
    # the velocity lacks what lies above the band and within a line
    assert sharp.sticking == pytest.approx(0.005 * velocity(setup), rel=0.01)

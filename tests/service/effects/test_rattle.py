"""Stops on either side of a mass, held against what a Gaussian motion feels of them by closed form."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import erfc

from modallab.effects.rattle import Rattle
from modallab.estimation.coherence import coherence
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.setup import RigSetup
from tests import oscillator
from tests.oscillator import FREQUENCY, STIFFNESS, TIP

STOP = 0.4 * STIFFNESS  # N/m


def rattling(gap: float, level: float = 1.0) -> tuple[RigSetup, Chain]:
    """The oscillator between stops, `gap` times its own root mean square displacement at level 1 away."""
    setup = oscillator.rig_at_tip(level, "periodic_random", window="rectangular", n_lines=5401)
    free = np.sqrt(oscillator.mean_square(oscillator.density(oscillator.rig_at_tip())))
    return setup, chain(oscillator.system(), setup, [Rattle(TIP, STOP, gap * free)])


def resonance(gap: float, level: float = 1.0) -> float:
    """In natural frequencies of the mass without stops."""
    return float(rattling(gap, level)[1].poles()[0][0, 0] / FREQUENCY)


def closed_form(gap: float) -> float:
    """The root of k' = k + k_s erfc(g / (s sqrt 2)) with s^2 = G/(4 c k'), over k: sqrt(k'/k)."""

    def left(ratio: float) -> float:
        return float(1 + STOP / STIFFNESS * erfc(gap * np.sqrt(ratio / 2)) - ratio)

    return float(np.sqrt(float(brentq(left, 1.0, 1 + STOP / STIFFNESS))))


def test_a_motion_that_stays_within_the_gap_never_meets_the_stops() -> None:
    setup, bench = rattling(gap=8.0)
    assert resonance(gap=8.0) == pytest.approx(1.0, rel=1e-12)  # erfc(8/sqrt 2) = 1e-15
    bare = chain(oscillator.system(), setup)
    found, wanted = expected_spectra(bench), expected_spectra(bare)
    np.testing.assert_allclose(found.fx, wanted.fx, rtol=1e-9)  # rounding, 1/zeta times as much at resonance
    np.testing.assert_allclose(coherence(found), 1.0, atol=1e-9)


def test_a_motion_far_beyond_the_gap_has_both_stops_for_a_spring() -> None:
    _, bench = rattling(gap=1e-3)
    # erfc x = 1 - 2 x/sqrt(pi): of a thousandth sqrt(2/pi), and more as the motion is less, to 1e-3
    assert resonance(gap=1e-3) == pytest.approx(np.sqrt(1 + STOP / STIFFNESS), rel=3e-4)
    assert coherence(expected_spectra(bench)).min() > 1 - 1e-3


@pytest.mark.parametrize("gap", [3.0, 2.0, 1.0, 0.3])
def test_between_the_stops_count_as_often_as_they_are_met(gap: float) -> None:
    """Booton (1954), IRE Trans. Circuit Theory 1, 9-18."""
    # kinks of the law between points of the quadrature; what the force has above the band: 1e-6
    assert resonance(gap) == pytest.approx(closed_form(gap), rel=2e-6)
    assert closed_form(gap) > 1.0003


def test_a_gap_twice_as_wide_is_met_as_often_at_twice_the_level() -> None:
    assert resonance(2.0, level=2.0) == pytest.approx(resonance(1.0), rel=1e-9)  # nothing else has a size


def test_coherence_is_least_where_the_motion_meets_the_stops_now_and_then() -> None:
    drops = [1 - coherence(expected_spectra(rattling(gap)[1])).min() for gap in (6.0, 1.5, 0.01)]
    assert drops[1] > 0.1
    assert max(drops[0], drops[2]) < 0.1 * drops[1]

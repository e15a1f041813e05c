"""A channel that does not let slow signals through."""

import numpy as np
from scipy.integrate import quad

from modallab.core.place import Channels
from modallab.effects.ac_coupling import AcCoupling
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from tests.rigs import beam_system, dofs, rig

SETUP = rig(1, 7, 16)
ONE = Channels(dofs(7))


def through(freq: list[float], corner: float) -> np.ndarray:
    """What the coupling makes of the FRF at 7:+Y."""
    pair: tuple[list[Effect], ...] = [], [AcCoupling(at=ONE, corner=corner)]
    bare, found = (chain(beam_system(), SETUP, e).respond(np.array(freq)).inertance for e in pair)
    return np.asarray(found / bare)[0, :, 1, 0]


def test_at_the_corner_it_is_three_decibels_down_and_leads_by_an_eighth_of_a_turn() -> None:
    (found,) = through([5.0], 5.0)
    np.testing.assert_allclose(abs(found), np.sqrt(0.5), rtol=1e-12)  # rounding
    np.testing.assert_allclose(np.degrees(np.angle(found)), 45.0, rtol=1e-12)


def test_it_is_the_transform_of_a_step_that_decays() -> None:
    """A capacitor behind a resistor: a step decays as exp(-t/tau), tau = 1/(2 pi f_c); the response to
    an impulse is that decay's derivative, delta(t) - exp(-t/tau)/tau."""
    corner, freq = 2.0, [0.5, 2.0, 7.0, 40.0]
    tau = 1 / (2 * np.pi * corner)
    wanted = []
    for f in freq:
        parts = [
            quad(lambda t: np.exp(-t / tau) / tau, 0, 30 * tau, weight=w, wvar=2 * np.pi * f)[0]
            for w in ("cos", "sin")
        ]
        wanted.append(1 - (parts[0] - 1j * parts[1]))
    # quadrature: 1.5e-8 absolute; cut off at exp(-30)
    np.testing.assert_allclose(through(freq, corner), wanted, atol=1e-7)


def test_far_below_the_corner_it_falls_by_twenty_decibels_a_decade() -> None:
    low, high = np.abs(through([2.0, 20.0], 1e4))
    # (f/f_c)^2 / 2 of itself: 2e-6
    assert np.isclose(high / low, 10.0, rtol=1e-5)


def test_coupled_alike_the_frf_is_right_and_the_auto_spectra_are_not() -> None:
    coupled = rig(1, 7, 16, analyser={"coupling": "ac", "coupling_frequency": 5.0})
    bare, found = (chain(beam_system(), setup) for setup in (SETUP, coupled))
    freq = SETUP.analyser.freq[1:]
    np.testing.assert_allclose(found.respond(freq).inertance, bare.respond(freq).inertance, rtol=1e-12)
    power = 1 / (1 + (5.0 / freq) ** 2)
    spectra = [expected_spectra(one) for one in (bare, found)]
    for name in ("ff", "xx"):
        ratio = (getattr(spectra[1], name) / getattr(spectra[0], name)).reshape(1, len(freq) + 1, -1)
        np.testing.assert_allclose(
            ratio[0, 1:], np.broadcast_to(power[:, None], ratio[0, 1:].shape), rtol=1e-9
        )


def test_a_force_of_another_corner_turns_every_frf() -> None:
    coupled = rig(1, 7, 16, analyser={"coupling": "ac", "coupling_frequency": 1.0})
    odd = AcCoupling(at=SETUP.drive, corner=3.0)
    freq = np.array([4.0])
    bare, found = (
        chain(beam_system(), s, e).respond(freq).inertance for s, e in ((SETUP, []), (coupled, [odd]))
    )
    # corners of 1 and 3 Hz on the force, 1 Hz on the responses: what is left is 1 - i 3/4
    np.testing.assert_allclose(found / bare, 1 - 0.75j, rtol=1e-12)

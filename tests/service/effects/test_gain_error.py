"""A channel that shows too much or too little."""

import numpy as np

from modallab.core.place import Channels
from modallab.effects.gain_error import GainError
from modallab.estimation.coherence import coherence
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from tests.rigs import beam_system, dofs, rig

FREQ = np.linspace(2.0, 800.0, 57)
SETUP = rig(1, 7, 16, noise=Noise(1e-3, 1e-4), analyser={"n_lines": 81})


def test_one_frf_is_that_of_a_structure_solved_line_by_line_times_the_factor() -> None:
    system = beam_system()
    alpha = direct_receptance(system, FREQ, system.selection(dofs(1, 7, 16)), system.selection(dofs(1)))
    wanted = -((2 * np.pi * FREQ) ** 2)[:, None] * alpha[..., 0] * [1.0, 0.93, 1.0]
    effect = GainError(at=Channels(dofs(7)), factor=0.93)
    found = chain(system, SETUP, [effect]).respond(FREQ).inertance[0, ..., 0]
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_power_goes_with_the_square_and_coherence_stays() -> None:
    bare, found = (expected_spectra(chain(beam_system(), SETUP, e)) for e in ([], [GainError(factor=1.2)]))
    # the noise is a share of what the channel shows, so it scales too; products and sums: rounding
    np.testing.assert_allclose(found.xx, 1.44 * bare.xx, rtol=1e-12)
    np.testing.assert_allclose(found.ff, bare.ff, rtol=1e-12)
    np.testing.assert_allclose(coherence(found), coherence(bare), rtol=1e-12)


def test_a_force_gauge_that_shows_too_much_makes_every_frf_too_small() -> None:
    bare, found = (
        chain(beam_system(), SETUP, e).respond(FREQ) for e in ([], [GainError(at=SETUP.drive, factor=1.25)])
    )
    np.testing.assert_allclose(found.inertance, bare.inertance / 1.25, rtol=1e-12)  # rounding
    np.testing.assert_array_equal(found.response, bare.response)

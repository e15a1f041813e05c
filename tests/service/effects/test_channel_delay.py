"""A channel that is late."""

import numpy as np

from modallab.core.place import Channels
from modallab.effects.channel_delay import ChannelDelay
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from tests.rigs import beam_system, dofs, rig

SETUP = rig(1, 7, 16)


def test_it_is_a_record_moved_by_whole_samples() -> None:
    n, moved = 1024, 3
    freq = SETUP.analyser.freq
    bare = chain(beam_system(), SETUP).respond(freq).response[0, :, 1, 0]
    record = np.roll(np.fft.irfft(bare, n), moved)
    wanted = np.fft.rfft(record)[1 : len(freq)]
    delay = moved / (n * SETUP.analyser.spacing)
    late = ChannelDelay(at=Channels(dofs(7)), delay=delay)
    found = chain(beam_system(), SETUP, [late]).respond(freq).response[0, 1:, 1, 0]
    # rounding of two transforms of 1024 samples
    np.testing.assert_allclose(found, wanted, atol=1e-11 * np.abs(wanted).max())


def test_ten_microseconds_are_three_degrees_at_800_hertz() -> None:
    freq = np.array([80.0, 800.0])
    bare, found = (
        chain(beam_system(), SETUP, e).respond(freq).inertance[0, :, 0, 0] for e in ([], [ChannelDelay()])
    )
    # 360 degrees x 800 Hz x 10 us = 2.88; rounding
    np.testing.assert_allclose(np.degrees(np.angle(found / bare)), [-0.288, -2.88], rtol=1e-9)


def test_what_all_channels_share_does_not_show() -> None:
    alike = [ChannelDelay(delay=1e-3), ChannelDelay(at=SETUP.drive, delay=1e-3)]
    bare, found = (expected_spectra(chain(beam_system(), SETUP, e)) for e in ([], alike))
    for name in ("ff", "fx", "xx"):  # a factor of size 1 and its inverse: rounding
        np.testing.assert_allclose(getattr(found, name), getattr(bare, name), rtol=1e-12)


def test_responses_that_are_early_are_a_force_that_is_late() -> None:
    pair = [ChannelDelay(delay=-2e-5)], [ChannelDelay(at=SETUP.drive, delay=2e-5)]
    early, late = (expected_spectra(chain(beam_system(), SETUP, e)) for e in pair)
    np.testing.assert_allclose(early.fx, late.fx, rtol=1e-12)  # rounding


def test_the_size_of_an_frf_stays() -> None:
    freq = SETUP.analyser.freq[1:]
    bare, found = (
        np.abs(chain(beam_system(), SETUP, e).respond(freq).inertance) for e in ([], [ChannelDelay()])
    )
    np.testing.assert_allclose(found, bare, rtol=1e-12)  # rounding

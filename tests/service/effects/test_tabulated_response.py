"""A tabulated response multiplies a channel by its curve, and no other channel."""

import numpy as np

from modallab.core.dof import Dof
from modallab.core.frequency_table import FrequencyTable
from modallab.core.place import Channels
from modallab.effects.tabulated_response import TabulatedResponse
from modallab.rig.chain import chain
from tests.rigs import beam_system, rig

FREQ = np.linspace(2.0, 800.0, 400)
GAIN = np.asarray(1 / (1 + 1j * FREQ / 500.0), complex)


def test_the_gain_of_its_channel_is_the_table() -> None:
    setup = rig(1, 7, 16)
    table = FrequencyTable.of(FREQ, GAIN).rows
    effect = TabulatedResponse(at=Channels((Dof(7, "Y"),)), table=table)
    without, with_gain = (
        chain(beam_system(), setup, effects).respond(FREQ).inertance[0, :, :, 0] for effects in ([], [effect])
    )
    expected = np.stack([np.ones(len(FREQ)), GAIN, np.ones(len(FREQ))], axis=1)
    np.testing.assert_allclose(with_gain / without, expected, rtol=1e-9)  # rounding of the spline

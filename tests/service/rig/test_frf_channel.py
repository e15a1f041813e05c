"""Every FRF of a test has one channel, and arrays go from one arrangement to the other and back."""

import numpy as np
import pytest

from modallab.rig.frf_channel import FrfLayout, frf_channels
from modallab.rig.hardware import Accelerometers, Exciter
from modallab.rig.setup import RigSetup
from tests.rigs import dofs


@pytest.mark.parametrize("roving", [False, True])
def test_channels_are_in_the_order_of_the_runs(roving: bool) -> None:
    setup = RigSetup(
        dofs(3, 5), dofs(1, 3), exciter=Exciter("hammer"), accelerometers=Accelerometers(roving=roving)
    )
    channels = frf_channels(setup)
    assert [str(channel) for channel in channels] == [
        "1:+Y / 3:+Y",
        "3:+Y / 3:+Y",
        "1:+Y / 5:+Y",
        "3:+Y / 5:+Y",
    ]
    assert [channel.run for channel in channels] == ([0, 1, 2, 3] if roving else [0, 0, 1, 1])
    assert [channel.at_drive_point for channel in channels] == [False, True, False, False]
    layout = FrfLayout.of(channels, setup.responses, setup.drives)
    values = np.arange(12.0).reshape(3, 2, 2)
    by_channel = layout.by_channel(values)
    np.testing.assert_array_equal(by_channel[0], [0.0, 2.0, 1.0, 3.0])
    np.testing.assert_array_equal(layout.by_dofs(by_channel), values)

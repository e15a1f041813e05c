"""The useful range of an accelerometer on its mounting."""

import numpy as np
import pytest

from modallab.rig.accelerometer_check import accelerometer_checks
from modallab.rig.checks import checks
from modallab.rig.hardware import Accelerometers
from tests.rigs import rig, steel_beam


@pytest.mark.parametrize(("top", "kept"), [(2000.0, True), (2400.0, False)])
def test_a_magnet_of_seven_kilohertz_is_good_for_two(top: float, kept: bool) -> None:
    setup = rig(7, accelerometers=Accelerometers(mounting="magnet"), analyser={"frequency_max": top})
    (found,) = accelerometer_checks(setup)
    assert found in checks(steel_beam(), setup)
    assert found.fulfilled is kept
    # 7000/3.3166 and 7000/4.5826 undamped; a loss of 0.1 moves them by 0.1^2/2
    np.testing.assert_allclose(
        [found.within_10_percent, found.within_5_percent], [2110.6, 1527.5], rtol=0.1**2 / 2
    )
    assert np.isclose(found.error_at_the_top, 1 / (1 - (top / 7e3) ** 2) - 1, rtol=0.01)  # the loss, as above


def test_ideal_accelerometers_have_no_end() -> None:
    assert accelerometer_checks(rig(7)) == ()

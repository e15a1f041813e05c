"""When an effect is told from nothing by the size that it was given."""

import numpy as np

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.searching.judging import clear_of_nothing
from modallab.effects.gain_error import GainError
from modallab.effects.mains_hum import MainsHum
from modallab.effects.transverse_sensitivity import TransverseSensitivity

HERE = Channels((Dof(5, "Y"),))


def test_an_amount_within_two_standard_errors_of_none_is_no_effect() -> None:
    assert clear_of_nothing(GainError(HERE, 1.05), {"factor": 0.02})
    assert not clear_of_nothing(GainError(HERE, 1.05), {"factor": 0.03})
    assert not clear_of_nothing(MainsHum(HERE, 0.01, 50.0), {"ratio": 0.006, "frequency": 0.02})


def test_an_amount_whose_direction_nothing_tells_is_left_to_the_likelihood() -> None:
    # Of a plane frame only sensitivity x cos(angle) counts: near 0 the angle may be anything, and with it
    # the sensitivity has any error, however well their product is known.
    tilted = TransverseSensitivity(HERE, -0.104, 0.009)
    assert clear_of_nothing(tilted, {"sensitivity": 0.47, "angle": np.pi})
    assert not clear_of_nothing(tilted, {"sensitivity": 0.47, "angle": 0.01})

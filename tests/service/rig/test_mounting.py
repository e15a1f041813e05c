"""How an accelerometer is held."""

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.core.errors import InvalidInputError
from modallab.rig.mounting import MOUNTINGS, reading, useful_frequency


@pytest.mark.parametrize(("deviation", "part"), [(0.1, 3.3166), (0.05, 4.5826)])
def test_undamped_the_limits_are_those_of_the_closed_form(deviation: float, part: float) -> None:
    """f_0 sqrt(1 - 1/1.1) and f_0 sqrt(1 - 1/1.05); f_0/3 and f_0/5 are what is easily remembered."""
    assert np.isclose(30e3 / useful_frequency(30e3, deviation), part, rtol=1e-5)  # digits printed


@pytest.mark.parametrize("loss", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("deviation", [0.02, 0.05, 0.1])
def test_it_is_where_the_reading_first_is_that_much_too_high(loss: float, deviation: float) -> None:
    def over(ratio: float) -> float:
        return float(np.abs(reading(np.array([ratio]), loss))[0] - 1 - deviation)

    assert np.isclose(useful_frequency(1.0, deviation, loss), brentq(over, 0.0, 0.6), rtol=1e-9)  # brentq


@pytest.mark.parametrize("loss", [2.0, 3.0])
def test_damped_so_much_that_it_only_falls_it_ends_where_the_reading_is_too_low(loss: float) -> None:
    def under(ratio: float) -> float:
        return float(np.abs(reading(np.array([ratio]), loss))[0] - 0.6)

    assert np.isclose(useful_frequency(1.0, 0.4, loss), brentq(under, 0.5, 20.0), rtol=1e-9)  # brentq


def test_firmer_mountings_reach_further() -> None:
    reach = [useful_frequency(MOUNTINGS[name].frequency, 0.05) for name in ("magnet", "wax", "stud")]
    assert reach == sorted(reach)


@pytest.mark.parametrize("deviation", [0.0, 1.0, -0.1, float("nan")])
def test_a_deviation_of_none_or_all_is_refused(deviation: float) -> None:
    with pytest.raises(InvalidInputError, match="deviation"):
        useful_frequency(1e4, deviation)

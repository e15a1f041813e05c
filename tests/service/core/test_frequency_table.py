"""A table over frequency is a smooth curve through its rows, and refuses what is no curve."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.frequency_table import FrequencyTable

FREQ = np.linspace(10.0, 500.0, 50)
CURVE = np.asarray(1e4 * (1 + 0.1j) + 3.0 * FREQ * (1 + 1j), complex)


def test_it_goes_through_its_rows_and_is_constant_beyond_them() -> None:
    table = FrequencyTable.of(FREQ, CURVE)
    np.testing.assert_allclose(table.at(FREQ), CURVE, rtol=1e-12)  # rounding of the spline's solution
    np.testing.assert_allclose(table.at(np.array([0.0, 900.0])), CURVE[[0, -1]], rtol=1e-12)


def test_between_rows_a_cubic_is_exact() -> None:
    between = (FREQ[1:] + FREQ[:-1]) / 2
    cubic = np.asarray(1e-6 * FREQ**3 + 2j * FREQ, complex)
    expected = 1e-6 * between**3 + 2j * between
    np.testing.assert_allclose(FrequencyTable.of(FREQ, cubic).at(between), expected, rtol=1e-9)  # rounding


def test_one_row_is_a_constant() -> None:
    assert set(FrequencyTable(((5.0, 2.0, 1.0),)).at(FREQ)) == {2 + 1j}


@pytest.mark.parametrize(
    "rows",
    [
        (),
        ((5.0, 1.0, 0.0), (5.0, 2.0, 0.0)),
        ((-1.0, 1.0, 0.0),),
        ((5.0, np.nan, 0.0),),
    ],
)
def test_what_is_no_curve_is_refused_by_its_field(rows: tuple[tuple[float, float, float], ...]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        FrequencyTable(rows)
    assert caught.value.context["field"] == "effects.table"

"""Lines that count, by bands."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.line_options import Band, line_mask

FREQ = np.arange(10.0, 101.0, 1.0)


def kept(bands: list[Band] | None = None, exclude: list[Band] | None = None) -> list[float]:
    mask = line_mask(FREQ, bands, exclude or [])
    assert mask is not None
    return [float(f) for f in FREQ[mask]]


def test_without_bands_all_lines_count() -> None:
    assert line_mask(FREQ) is None


def test_the_ends_of_a_band_belong_to_it() -> None:
    assert kept([(20.0, 22.0), (50.5, 52.0)]) == [20.0, 21.0, 22.0, 51.0, 52.0]


def test_excluded_bands_are_taken_out_of_bands() -> None:
    assert kept([(20.0, 24.0)], [(21.5, 23.0)]) == [20.0, 21.0, 24.0]
    assert kept(None, [(0.0, 99.0)]) == [100.0]


@pytest.mark.parametrize(
    ("bands", "exclude", "field"),
    [
        pytest.param([(30.0, 30.0)], [], "bands", id="no width"),
        pytest.param([(30.0, 20.0)], [], "bands", id="upside down"),
        pytest.param([(20.0, 30.0), (101.0, 200.0)], [], "bands", id="above the lines"),
        pytest.param(None, [(1.0, 9.0)], "exclude", id="below the lines"),
        pytest.param([(30.2, 30.8)], [], "bands", id="between two lines"),
        pytest.param([(20.0, 30.0)], [(15.0, 40.0)], "exclude", id="all taken out"),
        pytest.param([(np.nan, 30.0)], [], "bands", id="no number"),
    ],
)
def test_bands_that_leave_nothing_are_refused_by_name(
    bands: list[Band] | None, exclude: list[Band], field: str
) -> None:
    with pytest.raises(InvalidInputError) as refused:
        line_mask(FREQ, bands, exclude)
    assert refused.value.context["field"] == field

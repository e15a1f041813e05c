import numpy as np

from modallab.core.arrays import FloatArray
from modallab.extraction.multi_mode.frequency_ranges import find_frequency_ranges, orders_of
from modallab.extraction.options import MOST_ORDER, GlobalOptions
from modallab.extraction.preprocessing.bands import mode_indicator
from modallab.extraction.preprocessing.responses import responses_of
from tests.synthetic import HAMMERED, hammered

CHOSEN = GlobalOptions()


def peaks(n: int, lines: int) -> FloatArray:
    """Return an indicator with so many peaks, each 60 dB high."""
    return np.asarray(10 ** (3 + 3 * np.cos(2 * np.pi * n * (np.arange(lines) / lines + 0.5 / n))))


def test_orders_follow_the_peaks_up_to_what_a_chart_may_have() -> None:
    few, why = orders_of(peaks(5, 10_000), CHOSEN)
    assert (few[0], few[-1]) == (2, 36)
    assert why.startswith("36: 4 for each of 5 peaks")
    many, why = orders_of(peaks(300, 10_000), CHOSEN)
    assert many[-1] == MOST_ORDER
    assert f"at most {MOST_ORDER}" in why


def test_few_lines_tell_no_high_order_and_none_is_said_to_be_asked_for() -> None:
    orders, why = orders_of(peaks(20, 91), CHOSEN)
    assert orders[-1] == 30
    assert "at most one for 3 of the 91 lines" in why


def test_where_peaks_are_noise_only_the_bands_of_the_others_are_searched() -> None:
    frf = hammered(0, 3)
    responses = responses_of(frf, None, 100.0)
    searched = find_frequency_ranges(responses, mode_indicator(responses.mobility, responses.coherent), None)
    assert len(searched.left_out) == 1
    assert searched.ranges[0].stop < np.searchsorted(frf.freq, 973.0), (
        "below there is one range without noise"
    )
    for lines in searched.ranges:
        assert ((frf.freq[lines][0] < HAMMERED) & (frf.freq[lines][-1] > HAMMERED)).any()
    assert searched.description(frf.freq).endswith("Hz: peaks that FRFs have in common")

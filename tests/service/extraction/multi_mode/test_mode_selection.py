import numpy as np

from modallab.extraction.multi_mode.mode_selection import Selection, chart_of, select
from modallab.extraction.multi_mode.stabilisation import stabilise
from tests.service.extraction.charts import chart, pole

Rows = list[tuple[int, float, float]]


def column(frequency: float, loss_factor: float, first: int = 5, last: int = 20) -> Rows:
    return [(order, frequency, loss_factor) for order in range(first, last + 1)]


def scattered(seed: int, each: int = 2, last: int = 20) -> Rows:
    rng = np.random.default_rng(seed)
    return [
        (order, float(rng.uniform(150, 900)), float(rng.uniform(0.001, 0.05)))
        for order in range(5, last + 1)
        for _ in range(each)
    ]


def chosen(rows: Rows, strength: dict[float, float] | None = None) -> Selection:
    """Return what is selected; `strength` by frequency where it is not 100."""
    ranked = sorted(rows, key=lambda row: row[:2])
    poles = chart(ranked, strength=[(strength or {}).get(row[1], 100.0) for row in ranked])
    return select(poles, stabilise(poles))


def told(found: Selection) -> list[str]:
    """Return the rejected columns as text."""
    return [f"{pole.frequency:.5g} Hz: {pole.reason}" for pole in found.left_out]


def test_columns_are_modes_and_what_wanders_is_none() -> None:
    found = chosen(column(100.0, 0.02) + scattered(1) + column(120.0, 0.01))
    np.testing.assert_allclose(found.frequency, [100.0, 120.0])
    np.testing.assert_allclose(found.loss_factor, [0.02, 0.01])
    assert found.pairs == ()


def test_every_mode_says_why_it_is_one() -> None:
    found = chosen(column(100.0, 0.02, first=8))
    assert found.reasons == (
        "stable at 12 of 12 orders from 9 to 20, 12 of them in shape too; scatter 0 % in frequency and "
        "0 % in loss factor; 40 dB above the noise of a line",
    )


def test_close_modes_are_said_to_be_a_pair() -> None:
    found = chosen(column(100.0, 0.02) + column(102.0, 0.02) + column(120.0, 0.02))
    assert found.pairs == ((0, 1),)
    assert found.reasons[0].endswith("a pair with 102 Hz, 0.98 bandwidths away")
    assert found.reasons[1].endswith("a pair with 100 Hz, 0.98 bandwidths away")
    assert "pair" not in found.reasons[2]


def test_modes_three_bandwidths_apart_are_no_pair() -> None:
    assert chosen(column(100.0, 0.02) + column(106.5, 0.02)).pairs == ()


def test_a_column_of_noise_is_left_out_with_the_reason() -> None:
    found = chosen(column(100.0, 0.02) + column(140.0, 0.01), {140.0: 1.5})
    np.testing.assert_allclose(found.frequency, [100.0])
    assert told(found) == ["140 Hz: not above noise, 1.5 standard errors of a line"]


def test_a_column_too_short_is_left_out_with_the_reason() -> None:
    found = chosen(column(100.0, 0.02) + column(140.0, 0.01, first=17))
    np.testing.assert_allclose(found.frequency, [100.0])
    assert told(found) == ["140 Hz: stable at only 3 of 3 orders from 18 on"]


def test_a_column_that_is_lost_again_is_left_out_with_the_reason() -> None:
    found = chosen(column(100.0, 0.02) + column(140.0, 0.01, first=5, last=11))
    np.testing.assert_allclose(found.frequency, [100.0])
    assert told(found) == ["140 Hz: stable at only 6 of 15 orders from 6 on"]


def test_what_dies_away_at_once_is_no_resonance() -> None:
    found = chosen(column(100.0, 0.02) + column(140.0, 0.5))
    np.testing.assert_allclose(found.frequency, [100.0])
    assert told(found) == ["140 Hz: no resonance, loss factor 0.5"]


def test_what_a_single_line_shows_is_no_resonance() -> None:
    found = chosen(column(100.0, 0.02) + column(150.0, 1e-5))
    np.testing.assert_allclose(found.frequency, [100.0])
    # 0.0015 Hz wide at 0.5 Hz a line
    assert told(found) == ["150 Hz: a single line, not a resonance: bandwidth of 0.003 lines"]


def test_orders_without_any_pole_count_as_orders() -> None:
    poles = chart(column(100.0, 0.02, first=16, last=19), orders=range(2, 41))
    found = select(poles, stabilise(poles))
    assert told(found) == ["100 Hz: stable at only 3 of 24 orders from 17 on"]


def test_the_higher_orders_count() -> None:
    # noise biases low orders: here by a tenth of the bandwidth at the lowest, falling with the order
    rows = [(order, 100.0 + 0.2 * (5 / order) ** 6, 0.02) for order in range(5, 26)]
    found = chosen(rows)
    assert abs(found.frequency[0] - 100.0) < 0.2 * (5 / 15) ** 6
    assert found.frequency_scatter[0] < 1e-3


def test_a_short_chart_asks_for_fewer_orders() -> None:
    np.testing.assert_allclose(chosen(column(100.0, 0.02, first=4, last=8)).frequency, [100.0])


def test_the_chart_shows_which_poles_speak_for_which_mode() -> None:
    rows = sorted(column(100.0, 0.02) + scattered(4) + column(120.0, 0.01), key=lambda row: row[:2])
    poles = chart(rows)
    stability = stabilise(poles)
    found = select(poles, stability)
    shown = chart_of(poles, stability, found)
    np.testing.assert_array_equal(shown.mode == 0, np.isclose(poles.frequency, 100.0))
    np.testing.assert_array_equal(shown.mode == 1, np.isclose(poles.frequency, 120.0))
    np.testing.assert_allclose(shown.frequency, poles.frequency)
    np.testing.assert_allclose(poles.pole[shown.mode == 1], pole(120.0, 0.01))


def test_nothing_is_selected_from_nothing() -> None:
    found = chosen([])
    assert found.pole.shape == (0,)
    assert not found.reasons
    assert not found.left_out
    assert not found.pairs

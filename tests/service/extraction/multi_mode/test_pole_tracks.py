import numpy as np

from modallab.extraction.multi_mode.pole_tracks import pole_tracks
from tests.service.extraction.charts import chart


def test_the_same_pole_at_all_orders_is_one_column() -> None:
    poles = chart([(order, 100.0 + 0.01 * order, 0.02) for order in range(4, 20)])
    (column,) = pole_tracks(poles)
    assert poles.order[column].tolist() == list(range(19, 3, -1))


def test_two_poles_of_one_order_are_never_in_one_column() -> None:
    rows = [(order, frequency, 0.02) for order in range(4, 20) for frequency in (100.0, 100.3)]
    poles = chart(rows)  # 0.15 of a bandwidth apart
    columns = pole_tracks(poles)
    assert sorted(len(column) for column in columns) == [16, 16]
    assert all(np.ptp(poles.frequency[column]) < 1e-6 for column in columns)


def test_a_column_bridges_an_order_that_misses_it() -> None:
    poles = chart([(order, 100.0, 0.02) for order in (4, 5, 8, 9)])
    assert [len(column) for column in pole_tracks(poles)] == [4]


def test_every_pole_is_in_one_column() -> None:
    rng = np.random.default_rng(2)
    rows = [(order, float(rng.uniform(50, 60)), 0.05) for order in range(4, 30) for _ in range(3)]
    columns = pole_tracks(chart(rows))
    assert sorted(np.concatenate(columns).tolist()) == list(range(len(rows)))

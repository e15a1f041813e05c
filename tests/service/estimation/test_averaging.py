"""From records to spectra."""

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from modallab.estimation.averaging import Averager, counts_of, effective_averages
from modallab.estimation.windows import WINDOWS

N, RATE = 256, 512.0


def averaged(records: np.ndarray, window: str, n_in: int = 1, n_lines: int = N // 2 + 1) -> Averager:
    sums = Averager(WINDOWS[window], records.shape[1:], RATE, n_lines=n_lines, n_in=n_in)
    sums.add(records)
    return sums


def test_half_overlap_of_hanning_records_makes_a_hundred_worth_95() -> None:
    # Welch: 100/(1 + 2 (1 - 1/100)/36), as neighbours share a sixth of the window's power
    assert np.isclose(effective_averages(100, 0.5, WINDOWS["hann"]), 94.79, atol=0.005)


@pytest.mark.parametrize("window", sorted(WINDOWS))
def test_records_that_do_not_overlap_count_in_full(window: str) -> None:
    assert effective_averages(37, 0.0, WINDOWS[window]) == 37


def test_overlap_never_makes_records_worth_more_than_they_are_nor_less_than_the_time_they_take() -> None:
    for overlap in (0.25, 0.5, 0.75, 0.9):
        worth = effective_averages(200, overlap, WINDOWS["rectangular"])
        assert 200 * (1 - overlap) * 0.99 < worth < 200


def test_scatter_of_overlapped_spectra_is_that_of_the_effective_averages() -> None:
    rng = np.random.default_rng(0)
    n_tests, count = 3000, 100
    record = rng.standard_normal((n_tests, N // 2 * (count + 1)))
    spectra = []
    for one in record:
        blocks = sliding_window_view(one, N)[:: N // 2, None, :]
        sums = averaged(np.repeat(blocks, 2, axis=1), "hann")
        spectra.append(
            sums.densities()[0][10:-10:3, 0, 0].real
        )  # every third line: Hanning lines share power
    found = np.array(spectra)
    worth = found.mean() ** 2 / found.var(axis=0).mean()
    # the variance of a chi-square sample has relative error sqrt(2/n); three of them
    assert np.isclose(worth, 94.79, rtol=3 * np.sqrt(2 / found.size))


@pytest.mark.parametrize("window", sorted(WINDOWS))
def test_white_noise_is_flat_at_its_density_over_all_lines_and_zero_hertz_too(window: str) -> None:
    rng = np.random.default_rng(1)
    count, density = 4000, 3.0
    records = np.sqrt(density * RATE / 2) * rng.standard_normal((count, 2, N))
    ff, fx, xx = averaged(records, window, n_lines=N // 2).densities()
    error = np.sqrt(2 / count)  # of a chi-square of count degrees of freedom, at 0 Hz; less elsewhere
    kept = WINDOWS[window].noise_shares(1, 1)  # all but of windows that weigh parts of a record
    np.testing.assert_allclose(ff[:, 0, 0].real, kept[0] * density, rtol=4.5 * error)
    np.testing.assert_allclose(xx[:, 0], kept[1] * density, rtol=4.5 * error)
    np.testing.assert_allclose(fx[:, 0, 0] / density, 0, atol=4.5 * error)


def test_the_spectrum_of_a_record_holds_its_power() -> None:
    record = np.random.default_rng(2).standard_normal((1, 2, N))
    ff, _, xx = averaged(record, "rectangular").densities()
    weight = np.full(N // 2 + 1, RATE / N)
    weight[[0, -1]] /= 2  # these two lines have no twin at negative frequency
    assert np.isclose(weight @ xx[:, 0], (record[0, 1] ** 2).mean(), rtol=1e-13)  # Parseval; rounding
    assert np.isclose(weight @ ff[:, 0, 0].real, (record[0, 0] ** 2).mean(), rtol=1e-13)


def test_a_response_that_leads_the_force_has_a_positive_phase() -> None:
    t = np.arange(N) / RATE
    line = 20
    omega = 2 * np.pi * line * RATE / N
    record = np.array([np.cos(omega * t), 3 * np.cos(omega * t + 0.4)])[None]
    ff, fx, _ = averaged(record, "hann").densities()
    assert np.isclose(fx[line, 0, 0] / ff[line, 0, 0], 3 * np.exp(0.4j), rtol=1e-12)  # rounding


def test_records_in_one_go_or_in_pieces_give_the_same_sums() -> None:
    records = np.random.default_rng(4).standard_normal((23, 5, N))
    whole = averaged(records, "hann", n_in=2)
    pieces = Averager(WINDOWS["hann"], (5, N), RATE, n_lines=N // 2 + 1, n_in=2)
    for start in range(0, 23, 4):
        pieces.add(records[start : start + 4])
    assert whole.count == pieces.count == 23
    for a, b in zip(whole.densities(), pieces.densities(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_spectra_are_noted_on_the_way_as_if_the_test_had_ended_there() -> None:
    records = np.random.default_rng(6).standard_normal((9, 3, N))
    sums = Averager(WINDOWS["hann"], (3, N), RATE, n_lines=N // 2 + 1, n_in=1, noted=(1, 4, 8))
    for start in range(0, 9, 3):
        sums.add(records[start : start + 3])
    assert len(sums.snapshots) == 3
    for count, noted in zip((1, 4, 8), sums.snapshots, strict=True):
        for a, b in zip(noted, averaged(records[:count], "hann").densities(), strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("n", "averages", "first", "counts"),
    [
        (5, 100, 1, (1, 3, 10, 32, 100)),
        (10, 30, 1, (1, 2, 3, 4, 6, 8, 11, 15, 21, 30)),
        (24, 12, 1, tuple(range(1, 13))),
        (4, 16, 2, (2, 4, 8, 16)),
        (2, 30, 1, (1, 30)),
        (3, 1, 1, (1,)),
        (3, 1, 2, (1,)),
    ],
)
def test_counts_of_averages_have_ratios_as_equal_as_whole_numbers_allow(
    n: int, averages: int, first: int, counts: tuple[int, ...]
) -> None:
    assert counts_of(n, averages, first) == counts


def test_all_pairs_of_two_forces_and_the_responses_are_formed() -> None:
    records = np.random.default_rng(5).standard_normal((7, 5, N))
    ff, fx, xx = averaged(records, "hann", n_in=2).densities()
    lines = np.fft.rfft(records * WINDOWS["hann"].samples(N))
    f, x = lines[:, :2], lines[:, 2:]
    scale = 2 / (RATE * N * WINDOWS["hann"].power)
    np.testing.assert_allclose(ff, scale * np.einsum("bil,bjl->lij", f.conj(), f) / 7, atol=1e-15)  # rounding
    np.testing.assert_allclose(fx, scale * np.einsum("bil,bjl->lij", f.conj(), x) / 7, atol=1e-15)
    np.testing.assert_allclose(xx, scale * np.einsum("bil->li", np.abs(x) ** 2) / 7, atol=1e-15)

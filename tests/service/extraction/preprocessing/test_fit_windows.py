import numpy as np
import pytest

from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.fit_windows import (
    line_variance,
    place_windows,
    window_stride,
    without_nearest,
)
from modallab.extraction.single_mode.method import ModeFit


def test_a_window_follows_each_frf_and_stays_in_the_band() -> None:
    freq = np.arange(100.0)
    mobility = np.array([freq * ModeFit(f, 0.02, 1.0).response(freq) for f in (48.2, 50.3, 51.6)]).T
    indicator = (np.abs(mobility) ** 2).sum(axis=1)
    windows = place_windows(mobility, indicator, [Band(40, 70, 50)], base=8)
    centre = freq[windows.index[0]].mean(axis=1)
    # eight lines lie evenly round the peak, to half a line
    np.testing.assert_allclose(centre, [48.2, 50.3, 51.6], atol=0.8)
    assert windows.used.all()
    tight = place_windows(mobility, indicator, [Band(46, 51, 50)], base=8)
    assert tight.index.min() == 46
    assert tight.index.max() == 51


def test_a_wide_mode_has_a_window_of_three_bandwidths() -> None:
    freq = np.arange(1.0, 401.0)
    mobility = (freq * ModeFit(200.0, 0.1, 1.0).response(freq))[:, None]
    windows = place_windows(mobility, np.abs(mobility[:, 0]) ** 2, [Band(0, 399, 199)], base=8, widths=3)
    assert windows.index.shape[2] == pytest.approx(60, abs=6)  # 3 x 20 Hz at 1 Hz, a line at each end


@pytest.mark.parametrize("spacing", [1 / 8, 1 / 64, 1 / 1000])
def test_a_window_of_fine_lines_spans_the_resonance_with_few_of_them(spacing: float) -> None:
    freq = np.arange(1.0, 401.0, spacing)
    mobility = (freq * ModeFit(200.0, 0.1, 1.0).response(freq))[:, None]
    band = Band(0, len(freq) - 1, int(np.abs(mobility[:, 0]).argmax()))
    windows = place_windows(mobility, np.abs(mobility[:, 0]) ** 2, [band], base=8, widths=3)
    used = freq[windows.index[0, 0]]
    assert 48 < len(used) <= 96  # half of the largest window at least, as strides are powers of two
    assert np.ptp(used) == pytest.approx(60, rel=0.05)  # 3 x 20 Hz
    np.testing.assert_array_equal(np.diff(windows.index[0, 0]), windows.stride[0])
    first, last = windows.ends[0, 0]
    assert (first, last) == (windows.index[0, 0, 0], windows.index[0, 0, -1])
    assert window_stride(int(last - first) + 1) == windows.stride[0]


def test_an_frf_without_a_peak_of_its_own_is_read_at_the_common_one() -> None:
    freq = np.arange(100.0)
    mobility = np.stack([freq * ModeFit(50.0, 0.02, 1.0).response(freq), freq.astype(complex)], axis=1)
    indicator = np.abs(mobility[:, 0]) ** 2
    windows = place_windows(mobility, indicator, [Band(40, 60, 50)], base=9)
    np.testing.assert_array_equal(windows.index[0, 0], windows.index[0, 1])


def test_shorter_windows_are_padded() -> None:
    freq = np.arange(100.0)
    mobility = (freq * (ModeFit(20.0, 0.01, 1.0).response(freq) + ModeFit(60.0, 0.01, 1.0).response(freq)))[
        :, None
    ]
    indicator = np.abs(mobility[:, 0]) ** 2
    windows = place_windows(mobility, indicator, [Band(18, 22, 20), Band(40, 80, 60)], base=8)
    assert windows.used.sum(axis=2)[:, 0].tolist() == [5, 8]
    assert windows.index.max() < 100


def test_the_variance_is_that_of_averaged_spectra() -> None:
    # one tone of complex noise n on the response of H = 2: the error of H1 over 100 averages
    rng = np.random.default_rng(3)
    shape = (4000, 100)
    force = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    response = 2 * force + rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    h1 = (force.conj() * response).mean(axis=1) / (np.abs(force) ** 2).mean(axis=1)
    scatter = (np.abs(h1 - 2) ** 2).mean()
    stated = line_variance(np.array([[2.0 + 0j]]), np.array([[0.8]]), 100)[0, 0]
    # 4000 tests know the variance to 1.6 %; the first-order form is off by 1/100
    assert scatter == pytest.approx(stated, rel=0.06)


def test_a_line_that_says_nothing_has_no_bound_on_its_error() -> None:
    variance = line_variance(np.array([[1 + 0j, 0j, 1j]]), np.array([[0.0, 1.0, 1.0]]), 10)
    assert np.isinf(variance[0, :2]).all()
    assert 0 < variance[0, 2] < 1e-12


def test_the_lines_left_out_are_those_round_the_peak_and_four_always_stay() -> None:
    size = np.array([[1, 2, 4, 9, 7, 3, 2, 1.0], [1, 2, 4, 9, 7, 3, 2, 1.0]])
    used = np.ones((2, 8), bool)
    used[1, 6:] = False
    # from the highest to its higher neighbour, then the sides in turn
    assert np.flatnonzero(~without_nearest(size, used, 1)[0]).tolist() == [3]
    assert np.flatnonzero(~without_nearest(size, used, 3)[0]).tolist() == [2, 3, 4]
    kept = without_nearest(size, used, 4)
    assert kept.sum(axis=1).tolist() == [4, 4]
    assert np.flatnonzero(kept[1]).tolist() == [0, 1, 2, 5]

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.extraction.single_mode.screening import Screening, screen

N = 11


def screened(
    frequency: FloatArray, frequency_error: FloatArray | None = None, found: BoolArray | None = None
) -> Screening:
    return screen(
        frequency[None],
        np.full((1, N), 0.01),
        np.full((1, N), 0.001) if frequency_error is None else frequency_error[None],
        np.full((1, N), 1e-5),
        np.ones((1, N), bool) if found is None else found[None],
        1.0,
    )


def test_a_wandering_resonance_is_no_outlier() -> None:
    # roving mass: 749 to 753.4 Hz with most of them high, as in the 1992 thesis, table 5.4
    frequency = np.array([749.0, 750.5, 751.0, 751.5, 751.8, 752.0, 752.3, 752.8, 753.0, 753.2, 753.4])
    assert screened(frequency).good.all()


def test_a_fit_far_from_the_others_is_one() -> None:
    frequency = np.full(N, 100.0) + np.linspace(-0.1, 0.1, N)
    frequency[4] = 103.0
    result = screened(frequency)
    assert np.flatnonzero(result.outlying[0]).tolist() == [4]
    assert result.good.sum() == N - 1


def test_a_fit_with_a_large_error_is_unsure_and_not_an_outlier() -> None:
    frequency, error = np.full(N, 100.0), np.full(N, 0.001)
    frequency[4], error[4] = 100.3, 0.2
    result = screened(frequency, error)
    assert np.flatnonzero(result.unsure[0]).tolist() == [4]
    assert not result.outlying.any()


def test_fits_that_agree_to_rounding_are_not_set_against_each_other() -> None:
    frequency = np.full(N, 100.0)
    frequency[4] = 100.001
    assert screened(frequency, np.zeros(N)).good.all()


def test_one_vague_fit_makes_no_mode() -> None:
    found = np.zeros(N, bool)
    found[3] = True
    assert not screened(np.full(N, 100.0), np.full(N, 0.25), found).good.any()


def test_nothing_found_is_nothing_good() -> None:
    result = screened(np.zeros(N), found=np.zeros(N, bool))
    assert not result.good.any()
    assert result.unsure.all()

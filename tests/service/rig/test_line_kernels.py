"""How lines see a spectrum, against a closed form and against brute force."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import WINDOWS
from modallab.rig.acquisition import samples_of
from modallab.rig.analyser import Analyser
from modallab.rig.leakage_kernel import leak_spectrum
from modallab.rig.line_kernels import coarse_kernel, periodic_kernel, refined_kernel, refined_panels
from modallab.rig.line_selection import LineSelection

ANALYSER = Analyser(frequency_max=120.0, n_lines=81, window="hann")  # 1.5 Hz a line


def hanning_sees(resonance: float, half: float, lines: FloatArray) -> FloatArray:
    """Return what Hanning lines see of the power 1/((x - resonance)^2 + half^2), x in lines: closed form.

    The transform of the window's correlation times the signal's, pi/half exp(-2 pi half |t|).
    """
    s: ComplexArray = np.asarray(2 * np.pi * (half + 1j * (lines - resonance)), complex)

    def ramp(u: ComplexArray) -> ComplexArray:  # integral of (1 - t) exp(-u t) over a record
        return np.asarray(1 / u - (1 - np.exp(-u)) / u**2)

    w = 2j * np.pi
    correlation = ramp(s) / 4 + (ramp(s - w) + ramp(s + w)) / 16
    correlation += 3 / 8 * (1 - np.exp(-s)) / (s**2 - w**2)
    return np.asarray(2 * np.pi / half * correlation.real / (3 / 8))


@pytest.mark.parametrize("half", [1e-3, 0.05, 0.25, 1.0, 3.0])
@pytest.mark.parametrize("place", [40.0, 40.2, 40.5])
def test_a_resonance_between_lines_is_seen_as_its_closed_form(half: float, place: float) -> None:
    d = ANALYSER.spacing
    grid = refined_panels(ANALYSER, np.array([place * d]), np.array([half * d]))
    view = leak_spectrum("hann", ANALYSER.n_lines, d, *grid)  # of continuous time, as the closed form is
    x = view.nodes / d
    seen = view.convolve((1 / ((x - place) ** 2 + half**2))[None, :, None].astype(complex))[0, :, 0]
    near = np.arange(30, 51)
    closed = hanning_sees(place, half, near.astype(float))
    # the band ends 30 lines away, where a Hanning line takes 30^-6 of what it takes at home; the terms
    # of the closed form cancel to 1e-12 of the largest line
    np.testing.assert_allclose(seen[near].real, closed, rtol=1e-7, atol=1e-11 * closed.max())
    assert np.abs(seen.imag).max() < 1e-15 * closed.max()  # rounding


def test_a_look_without_refinement_is_near_where_resonances_are_a_line_wide() -> None:
    d = ANALYSER.spacing
    for place in (40.0, 40.3):
        view = coarse_kernel(ANALYSER, LineSelection.every(2, ANALYSER.n_lines))
        x = view.nodes / d
        seen = view.convolve((1 / ((x - place) ** 2 + 0.25)).astype(complex)[None, :, None])[0, :, 0]
        even = np.arange(30, 51, 2)
        closed = hanning_sees(place, 0.5, even.astype(float))
        # midpoints h = half a line apart, a pole a = half a line away, the line shape W there: of a peak of
        # 2.4 they miss 2 exp(-2 pi a / h) (pi / a) W(ia)^2 / 1.5 = 0.0215 at most
        np.testing.assert_allclose(seen[even // 2].real, closed, rtol=0, atol=0.022)


@pytest.mark.parametrize("window", [kind for kind in sorted(WINDOWS) if not WINDOWS[kind].transient])
def test_white_noise_is_seen_as_it_is_by_lines_inside_the_band(window: str) -> None:
    analyser = Analyser(frequency_max=120.0, n_lines=81, window=window)
    view = refined_kernel(analyser, np.array([]), np.array([]))
    seen = view.convolve(np.ones((1, len(view.nodes), 1), complex))[0, :, 0]
    # with a rectangular record 1/(pi^2 x) of the power comes from beyond x lines away, each side
    far = 1.2 / (2 * np.pi**2 * 20) * 2 if window == "rectangular" else 1e-7
    np.testing.assert_allclose(seen[:61].real, 1.0, rtol=far)
    # below 0 Hz the spectrum goes on; above the top of the band there is none
    half = 0.5 if window == "rectangular" else 0.5 + 1e-9
    assert np.isclose(seen[-1].real, half, rtol=0.01)


def test_a_cross_spectrum_below_zero_hertz_is_the_conjugate_of_that_above() -> None:
    view = refined_kernel(ANALYSER, np.array([]), np.array([]))
    seen = view.convolve(np.full((1, len(view.nodes), 1), 1j))[0, :, 0]
    assert abs(seen[0]) < 1e-15  # as much of i as of -i
    # of line 1 two thirds lie above 1/2; by symmetry about itself it takes the odd part once more
    assert 0.5 < seen[1].imag < 1.0
    np.testing.assert_allclose(seen[10:61].imag, 1.0, rtol=1e-6)  # 10 lines away: 10^-6 of the power


def test_a_periodic_signal_through_a_rectangular_record_is_not_smeared() -> None:
    analyser = Analyser(frequency_max=120.0, n_lines=81, window="rectangular")
    view = periodic_kernel(analyser)
    spectrum = np.random.default_rng(0).standard_normal((2, 81, 3)).astype(complex)
    np.testing.assert_array_equal(view.convolve(spectrum), spectrum)


def test_a_periodic_signal_through_a_hanning_record_reaches_the_next_lines_alone() -> None:
    view = periodic_kernel(ANALYSER)
    spectrum = np.zeros((1, 81, 1), complex)
    spectrum[0, 40] = 1.0
    seen = view.convolve(spectrum)[0, :, 0].real
    np.testing.assert_allclose(seen[38:43], [0, 1 / 6, 2 / 3, 1 / 6, 0], atol=1e-15)  # rounding


@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_distant_nodes_of_a_coarse_grid_count_in_blocks(window: str) -> None:
    analyser = Analyser(frequency_max=800.0, n_lines=1601, window=window)
    lines = LineSelection.every(8, analyser.n_lines)
    view = coarse_kernel(analyser, lines)
    x = view.nodes / analyser.spacing
    spectrum = (1 / np.abs(x**2 - 400.3**2 * (1 + 0.02j)) ** 2 + 1j / (1 + (x - 900.0) ** 2))[None, :, None]
    seen = view.convolve(spectrum)[0, :, 0]
    n = samples_of(analyser)
    near, mirrored = (
        analyser.line_window.line_shapes(lines.indices.astype(float), p, n) / 2 for p in (x, -x)
    )
    every = spectrum[0, :, 0]
    wanted = (near + mirrored) @ every.real + 1j * (near - mirrored) @ every.imag
    # a block's shape at its centre: 0.4 % of what leaks far, without a window
    np.testing.assert_allclose(seen.real, wanted.real, rtol=4e-3)
    np.testing.assert_allclose(seen.imag, wanted.imag, rtol=4e-3)


def test_the_kernel_of_few_of_many_lines_is_small() -> None:
    analyser = Analyser(frequency_max=12_800.0, n_lines=51_201, window="hann")
    view = coarse_kernel(analyser, LineSelection.every(393, analyser.n_lines))
    assert view.near is not None
    assert view.far is not None
    # 131 lines see 102,400 nodes: 107 MB in full; 272 nodes and 6,400 blocks of each line here
    assert view.near.data.nbytes + view.far.nbytes < 8e6

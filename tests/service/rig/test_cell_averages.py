"""Averages of spectra whose peaks are narrower than the cells of a grid."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.fe.damping import StructuralDamping
from modallab.rig.cell_averages import CellAverages, mean_about
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from tests.rigs import beam_system, dofs, rig

SPACING, N_LINES = 0.5, 201
HALF_WIDTH = 0.02


def peak(freq: FloatArray, centre: float, half_width: float = HALF_WIDTH) -> FloatArray:
    """A Lorentz curve of unit area."""
    return half_width / np.pi / ((freq - centre) ** 2 + half_width**2)


def on_grid(centre: float) -> FloatArray:
    """The peak on the grid, averaged near its centre."""
    averages = CellAverages.near(SPACING, N_LINES, np.array([centre]), np.array([HALF_WIDTH]))
    values = peak(np.linspace(0.0, SPACING * (N_LINES - 1), N_LINES), centre)
    values[averages.points] = averages.weights @ peak(averages.nodes, centre)
    return values


@pytest.mark.parametrize("centre", [50.0, 50.07, 50.25, 50.4])
def test_averages_keep_power_and_place_of_a_narrow_peak(centre: float) -> None:
    values, grid = on_grid(centre), SPACING * np.arange(N_LINES)
    inside = np.arctan(np.array([-centre, 100 - centre]) / HALF_WIDTH) / np.pi  # power from 0 to 100 Hz
    # 1e-3: beyond 8 Hz samples stand for averages, 0.2 % off, of flanks with 0.2 % of the power.
    assert SPACING * values.sum() == pytest.approx(inside[1] - inside[0], abs=1e-3)
    near = np.abs(grid - centre) < 2.0  # flanks are even about the centre, the grid is not
    assert np.sum(values[near] * grid[near]) / values[near].sum() == pytest.approx(centre, abs=0.01)


def test_a_resolved_peak_is_sampled() -> None:
    wide = CellAverages.near(SPACING, N_LINES, np.array([50.0]), np.array([3 * SPACING]))
    assert len(wide.points) == 0


def test_a_mean_about_frequencies_keeps_power_and_place_of_what_lies_between() -> None:
    grid: FloatArray = np.linspace(0.0, 200.0, 4001)
    values = peak(grid, 61.3, 0.2)
    freq = np.random.default_rng(1).permutation(np.arange(0.5, 200.0, 1.0))  # in any order
    means = mean_about(freq, grid, values)
    power = grid[1] * values.sum()
    near = np.abs(freq - 61.3) < 12.0
    assert means.sum() == pytest.approx(power, abs=2e-3)  # of flanks beyond the first and the last frequency
    assert np.sum(means[near] * freq[near]) / means[near].sum() == pytest.approx(61.3, abs=0.02)


def test_a_mean_about_close_frequencies_is_the_curve_itself() -> None:
    grid: FloatArray = np.linspace(0.0, 200.0, 4001)
    values = peak(grid, 61.3, 2.0)
    freq = np.linspace(60.0, 62.0, 101)
    np.testing.assert_array_equal(mean_about(freq, grid, values), np.interp(freq, grid, values))


def test_spectra_change_smoothly_with_a_spring_that_shifts_a_narrow_resonance() -> None:
    """A spring to the ground makes a resonance of a rigid-body motion, a thousandth of a line wide."""
    setup = rig(1, 7, excitation="random", analyser={"n_lines": 401, "window": "hann"})
    system = beam_system(StructuralDamping(stiffness_coefficient=1e-3, mass_coefficient=0.0))

    def power(stiffness: float) -> FloatArray:
        whole = chain(system, setup, [CubicStiffness(dofs(7)[0], stiffness)])
        return expected_spectra(whole).xx[0, 2:, 0]

    def slope(step: float) -> float:
        return float(np.sqrt(np.mean((np.log(power(1e9 * np.exp(step)) / power(1e9)) / step) ** 2)))

    # A factor of 2: the slope itself changes by a sixth. Samples of the peak would make it 34 times.
    assert slope(1e-4) == pytest.approx(slope(0.1), rel=1.0)

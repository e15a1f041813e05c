"""Leakage by near and far parts, against the plain sum over all pairs of line and node."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import WINDOWS
from modallab.rig.leakage_kernel import leak_spectrum

SPACING = 0.5


def plain(
    window: str, n_lines: int, nodes: FloatArray, weights: FloatArray, s: ComplexArray, n: int | None
) -> ComplexArray:
    shape, line = WINDOWS[window], np.arange(n_lines)[:, None]
    place = nodes / SPACING
    above, below = shape.line_shape(line - place, n), shape.line_shape(line + place, n)
    share = weights[:, None] / SPACING
    seen = [above @ (share * one) + below @ (share * one.conj()) for one in s]
    return np.array(seen)


@pytest.mark.parametrize("window", [kind for kind in sorted(WINDOWS) if not WINDOWS[kind].transient])
@pytest.mark.parametrize("n_lines", [2, 5, 12, 19, 67])
@pytest.mark.parametrize("sampled", [False, True])
def test_every_line_takes_from_every_node_what_the_line_shape_says(
    window: str, n_lines: int, sampled: bool
) -> None:
    n_samples = int(np.ceil(2.56 * (n_lines - 1))) if sampled else None
    rng = np.random.default_rng(n_lines)
    nodes = rng.uniform(0, (n_lines - 1) * SPACING, 40 * n_lines)
    weights = rng.uniform(0, 1, nodes.shape)
    spectrum = rng.standard_normal((2, len(nodes), 3)) + 1j * rng.standard_normal((2, len(nodes), 3))
    spectrum *= 10 ** rng.uniform(-3, 3, (1, len(nodes), 1))
    seen = leak_spectrum(window, n_lines, SPACING, nodes, weights, n_samples).convolve(spectrum)
    # 1e-9 of what comes from afar, and that is at most 1e-3 of what is near
    wanted = plain(window, n_lines, nodes, weights, spectrum, n_samples)
    np.testing.assert_allclose(seen, wanted, atol=1e-12 * np.abs(wanted).max())


def test_one_strong_node_is_felt_rightly_at_the_farthest_line() -> None:
    nodes, weights = np.array([0.2 * SPACING]), np.array([SPACING])
    seen = (
        leak_spectrum("hann", 400, SPACING, nodes, weights)
        .convolve(np.ones((1, 1, 1), complex))[0, :, 0]
        .real
    )
    window = WINDOWS["hann"]
    line = np.arange(400.0)
    wanted = window.line_shape(line - 0.2) + window.line_shape(line + 0.2)
    np.testing.assert_allclose(seen[:60], wanted[:60], rtol=2e-9)  # of the polynomials
    # 10^-15 of the node's own line and less: lost beside the rounding of the transform, and never seen
    np.testing.assert_allclose(seen, wanted, atol=1e-18)


def test_few_interpolation_points_keep_a_thousandth_of_what_leaks_from_afar() -> None:
    rng = np.random.default_rng(1)
    nodes, weights = rng.uniform(0, 99 * SPACING, 500), rng.uniform(0, 1, 500)
    inside = (nodes > 40 * SPACING) & (nodes < 60 * SPACING)
    spectrum = np.where(inside, rng.uniform(0, 1, 500), 0.0)[None, :, None].astype(complex)
    kernels = [leak_spectrum("rectangular", 100, SPACING, nodes, weights, n_points=n) for n in (10, 4)]
    many, few = (kernel.convolve(spectrum)[0, :, 0].real for kernel in kernels)
    far = np.r_[:30, 70:100]
    np.testing.assert_allclose(few[far], many[far], rtol=1e-3)  # its settings say so

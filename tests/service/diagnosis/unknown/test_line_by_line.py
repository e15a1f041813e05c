import numpy as np

from modallab.diagnosis.unknown.line_by_line import Influence


def influence() -> Influence:
    rng = np.random.default_rng(0)
    parts = rng.standard_normal((4, 5, 3))
    coupling, own = parts[0] + 1j * parts[1], parts[2] + 1j * parts[3]
    own[:, 0] = coupling[:, 0]  # a stiffness at the drive itself
    return Influence(coupling, own)


def test_derivatives_of_a_ratio_are_its_differences() -> None:
    z, step = np.asarray(np.linspace(0.5, 2.0, 5) * (1 + 0.5j), np.complex128), 1e-6
    by_difference = (influence().ratio(z + step) - influence().ratio(z - step)) / (2 * step)
    np.testing.assert_allclose(influence().derivative(z), by_difference, rtol=1e-8)  # O(step^2) = 1e-12
    np.testing.assert_allclose(
        influence().logarithmic_derivative(z), by_difference / influence().ratio(z), rtol=1e-8
    )


def test_a_motion_that_a_large_stiffness_stops_has_finite_derivatives() -> None:
    z = np.full(5, 1e40 + 0j)
    assert (influence().ratio(z)[:, 0] == 0).all()  # so that no quotient by it exists
    assert np.isfinite(influence().logarithmic_derivative(z)).all()

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS, Poles
from modallab.extraction.multi_mode.mode_selection import select
from modallab.extraction.multi_mode.stabilisation import stabilise

FREQ = np.arange(20.0, 120.0, 0.25)
POLE = 2 * np.pi * np.array([-0.3 + 45j, -0.4 + 70j, -0.4 + 70j, -0.5 + 100j])  # two of them coincide
SHAPE = np.random.default_rng(3).standard_normal((4, 8))
NOISE = 1e-3  # of the rms of each FRF


def two_inputs() -> tuple[ComplexArray, FloatArray]:
    """(n_freq, 8, 2) with noise: driven at the first two points."""
    residue = SHAPE[:, :, None] * SHAPE[:, None, :2]
    s = 2j * np.pi * FREQ[:, None, None, None]
    terms = residue / (s - POLE[:, None, None]) + residue / (s - POLE[:, None, None].conj())
    frf = terms.sum(axis=1)
    level = NOISE * np.sqrt(np.mean(np.abs(frf) ** 2, axis=0))
    rng = np.random.default_rng(4)
    error = rng.standard_normal(frf.shape) + 1j * rng.standard_normal(frf.shape)
    return frf + level * error / np.sqrt(2), np.broadcast_to(1 / level**2, frf.shape)


def poles_of(kind: str, frf: ComplexArray, weight: FloatArray) -> Poles:
    return GLOBAL_METHODS[kind](FREQ, frf, weight, np.arange(2, 25))


def test_two_inputs_tell_two_modes_of_one_frequency() -> None:
    frf, weight = two_inputs()
    poles = poles_of("poly_reference_lscf", frf, weight)
    found = select(poles, stabilise(poles))
    # noise of 60 dB: 1e-5 of a frequency and half a percent of damping
    np.testing.assert_allclose(found.frequency, np.abs(POLE) / (2 * np.pi), rtol=5e-5)
    np.testing.assert_allclose(found.loss_factor, -2 * POLE.real / np.abs(POLE), rtol=0.02)
    assert (1, 2) in found.pairs


def test_a_common_denominator_tells_but_one_of_them() -> None:
    poles = poles_of("lscf", *two_inputs())
    found = select(poles, stabilise(poles))
    np.testing.assert_allclose(found.frequency, [45, 70, 100], rtol=5e-5)


def test_the_residue_of_a_pole_is_of_rank_one_in_points_and_inputs() -> None:
    poles = poles_of("poly_reference_lscf", *two_inputs())
    top = poles.order == 24
    residue = poles.vector[top][np.abs(poles.pole[top] - POLE[0]).argmin()].reshape(8, 2)
    singular = np.linalg.svd(residue, compute_uv=False)
    assert singular[1] < 1e-9 * singular[0]
    exact = SHAPE[0][:, None] * SHAPE[0][None, :2]
    assert np.abs(residue - exact).max() < 0.01 * np.abs(exact).max()


def test_with_one_input_it_is_the_scalar_method() -> None:
    frf, weight = two_inputs()
    one = poles_of("poly_reference_lscf", frf[:, :, :1], weight[:, :, :1])
    scalar = poles_of("lscf", frf[:, :, :1], weight[:, :, :1])
    np.testing.assert_array_equal(one.pole, scalar.pole)


def test_the_unit_of_an_input_does_not_matter() -> None:
    frf, weight = two_inputs()
    gain = np.array([1.0, 1e4])
    as_it_is = poles_of("poly_reference_lscf", frf, weight)
    other = poles_of("poly_reference_lscf", frf * gain, weight / gain**2)
    np.testing.assert_allclose(other.pole, as_it_is.pole, rtol=1e-7)  # rounding, of condition 1e6

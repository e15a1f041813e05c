"""Quantisation against Widrow's theory, its limits by quadrature of the rounding itself."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels
from modallab.core.progress import silent
from modallab.effects.quantisation import Quantisation
from modallab.estimation.estimator import ESTIMATORS
from modallab.rig.acquisition import samples_of
from modallab.rig.analyser import Analyser
from modallab.rig.chain import all_effects, chain
from modallab.rig.effect import build
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, dofs, rig

SETTINGS = {"n_lines": 101, "window": "hann", "averages": 1000}


def rounded_normal(step: float) -> tuple[float, float]:
    """Gain and mean square error of rounding a normal variable: sums over the steps, no theory."""
    whole = step * np.arange(-np.ceil(10 / step), np.ceil(10 / step) + 1)
    inside = np.diff(norm.cdf(np.append(whole - step / 2, whole[-1] + step / 2)))
    below, above = norm.pdf(whole - step / 2), norm.pdf(whole + step / 2)
    gain = float(whole @ (below - above))  # E[x round(x)] of each step in closed form
    power = float(whole**2 @ inside)
    return gain, power - 2 * gain + 1


def test_the_sums_over_steps_are_right() -> None:
    gain, error = rounded_normal(1.3)
    weighted = [(lambda x: 1.3 * np.round(x / 1.3) * x), (lambda x: (1.3 * np.round(x / 1.3) - x) ** 2)]
    jumps = 1.3 * (np.arange(-7, 7) + 0.5)
    for found, g in zip((gain, error), weighted, strict=True):
        wanted, _ = quad(lambda x, g=g: g(x) * norm.pdf(x), -9, 9, points=jumps, limit=200)
        assert np.isclose(found, wanted, atol=1e-10)


@pytest.mark.parametrize(("step", "within"), [(0.03, 1e-9), (1.0, 1e-6), (1.5, 3e-3)])
def test_a_twelfth_of_the_squared_step_is_the_noise_of_rounding_a_gaussian_signal(
    step: float, within: float
) -> None:
    gain, error = rounded_normal(step)
    # Widrow, Kollar and Liu (1996): what is left out is of the order of exp(-2 pi^2/step^2), 12/pi^2 of it
    # in the power: 3e-9 at one step per standard deviation, 1.5e-4 at one and a half.
    assert np.isclose(error, step**2 / 12, rtol=within)
    assert np.isclose(gain, 1.0, rtol=within)


def test_at_two_standard_deviations_a_step_the_two_routes_part_by_some_per_cent() -> None:
    gain, error = rounded_normal(2.0)
    assert 0.01 < 1 - gain < 0.02  # the expected route has 1
    assert 0.005 < 1 - error / (4 / 12) < 0.05


def test_expected_noise_is_white_to_half_the_sample_rate() -> None:
    setup = rig(1, 7, analyser=SETTINGS)
    bare = expected_spectra(chain(beam_system(), setup))
    found = expected_spectra(chain(beam_system(), setup, [Quantisation(step=0.1)]))
    half_rate = samples_of(setup.analyser) * 8.0 / 2
    for channel, (a, b) in enumerate([(found.ff.real, bare.ff.real), (found.xx, bare.xx)]):
        rms2 = 800 * b.mean(axis=1)
        flat = np.broadcast_to((0.1**2 * rms2 / 12 / half_rate)[:, None], a.shape)
        np.testing.assert_allclose(a - b, flat, rtol=1e-6, err_msg=str(channel))  # rounding of a difference


@pytest.mark.parametrize("step", [0.3, 1.0])
@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
def test_rounded_records_have_the_expected_spectra(excitation: str, step: float) -> None:
    setup = rig(1, 7, 16, excitation=excitation, analyser=SETTINGS)
    whole = chain(beam_system(), setup, [Quantisation(step=step)])
    sampled, wanted = sampled_spectra(whole, np.random.default_rng(1), silent), expected_spectra(whole)
    assert relative(sampled.xx, wanted.xx, 1000) >= 0.97  # neighbouring lines are tied by the window
    assert relative(sampled.ff.real, wanted.ff.real, 1000) >= 0.97
    # where the noise is all there is, at the antiresonances, it must be right on its own
    quiet = wanted.xx < 2 * np.min(wanted.xx, axis=1, keepdims=True)
    assert np.isclose((sampled.xx / wanted.xx)[quiet].mean(), 1, atol=4 / np.sqrt(1000 * quiet.sum() / 2))


def test_windows_of_impacts_let_through_as_much_of_the_rounding_as_of_any_noise() -> None:
    settings = {"n_lines": 201, "window": "force_exponential", "averages": 400}
    setup = rig(
        *(1, 7),
        excitation="impact",
        exciter=Exciter("hammer"),
        noise=Noise(0.03, 0.03),  # two thirds of a step, or every blow is rounded alike
        analyser=settings,
    )
    whole = chain(beam_system(), setup, [Quantisation(step=0.3)])
    sampled, wanted = sampled_spectra(whole, np.random.default_rng(2), silent), expected_spectra(whole)
    bare = expected_spectra(chain(beam_system(), setup))
    quiet = wanted.xx < 3 * wanted.xx.min()
    ratio = (sampled.xx / wanted.xx)[quiet]
    error = ratio.std() / np.sqrt(len(ratio) / 2)  # the exponential window ties two lines
    assert abs(ratio.mean() - 1) < 4 * error
    assert (wanted.xx / bare.xx)[
        quiet
    ].mean() - 1 > 4 * error  # it can be seen; unweighted it were nine times as much


def relative(found: FloatArray, wanted: FloatArray, averages: int) -> float:
    """Share of the lines within three random errors; 0.997 if they are normal and independent."""
    return float((np.abs(found / wanted - 1) < 3 / np.sqrt(averages))[:, 1:].mean())


def test_only_the_channels_named_are_rounded() -> None:
    setup = rig(1, 7, analyser=SETTINGS)
    bare = expected_spectra(chain(beam_system(), setup))
    found = expected_spectra(chain(beam_system(), setup, [Quantisation(Channels(dofs(7)), step=0.1)]))
    np.testing.assert_array_equal(found.ff, bare.ff)
    np.testing.assert_array_equal(found.xx[..., 0], bare.xx[..., 0])
    assert (found.xx[..., 1] > bare.xx[..., 1]).all()


def test_six_decibels_a_bit() -> None:
    noise = []
    for bits in (8, 9, 10):
        setup = rig(1, analyser={"n_lines": 101, "bits": bits})
        ideal = expected_spectra(chain(beam_system(), rig(1, analyser={"n_lines": 101})))
        with_bits = expected_spectra(chain(beam_system(), setup, []))
        # what clipping at four standard deviations takes is 1e-5 of the force, and the same for all
        noise.append(float((with_bits.ff - ideal.ff).real.mean() / ideal.ff.real.mean()))
    first, second = noise[0] - noise[1], noise[1] - noise[2]
    assert np.isclose(first / second, 4.0, rtol=1e-6)  # a quarter of the power for each bit more


def test_declared_bits_round_and_clip_and_an_ideal_converter_does_neither() -> None:
    bits = Analyser(bits=12, range_factor=5.0)
    implied = {
        e.kind: e.parameters for e in all_effects(rig(1, analyser={"bits": 12, "range_factor": 5.0}), [])
    }
    assert implied == {"overload": {"level": 5.0}, "quantisation": {"step": 10 / 4096}}
    assert all_effects(rig(1), []) == []
    assert bits.bits == 12


def test_the_coarsest_converter_of_a_log_book_is_within_the_bounds_of_its_effects() -> None:
    for bits, factor in ((4, 16.0), (4, 0.5), (7, 100.0), (32, 100.0)):
        implied = all_effects(rig(1, analyser={"bits": bits, "range_factor": factor}), [])
        assert [build(effect.spec) for effect in implied] == implied
    with pytest.raises(InvalidInputError, match="bits"):
        Analyser(bits=6, range_factor=100.0)


def test_sixteen_bits_leave_the_frf_as_it_is() -> None:
    ideal, good = (rig(1, 7, analyser={"n_lines": 101, **more}) for more in ({}, {"bits": 16}))
    h, wanted = (ESTIMATORS["h1"](expected_spectra(chain(beam_system(), s))) for s in (good, ideal))
    # What clipping at four standard deviations takes is 6e-5 of both signals; at 0 Hz the free beam hardly
    # answers at all.
    np.testing.assert_allclose(h[:, 1:], wanted[:, 1:], rtol=2e-4)

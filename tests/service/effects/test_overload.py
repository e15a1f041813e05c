"""Overload against quadrature of clipped Gaussian signals, and against clipping itself."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline
from scipy.stats import norm

from modallab.core.place import Channels
from modallab.core.progress import silent
from modallab.effects.overload import Overload
from modallab.estimation.clipping import bussgang_gain, clipped_power, hermite_coefficients
from modallab.estimation.coherence import coherence, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.rig.chain import chain
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, dofs, rig

LEVELS = [0.5, 1.0, 2.0, 3.0]


def part(level: float, order: int) -> float:
    """Coefficient of a normalised Hermite polynomial in a clipped normal variable, by quadrature."""
    polynomial = np.polynomial.hermite_e.HermiteE.basis(order)

    def product(x: float) -> float:
        return float(np.clip(x, -level, level) * polynomial(x) * norm.pdf(x))

    value, _ = quad(product, -12, 12, points=[-level, level], limit=400, epsabs=1e-13)
    return float(value / np.sqrt(np.prod(np.arange(1.0, order + 1))))


@pytest.mark.parametrize("level", LEVELS)
def test_gain_power_and_orders_of_a_clipped_gaussian_signal_are_those_of_quadrature(level: float) -> None:
    c = np.array(level)
    assert np.isclose(bussgang_gain(c), part(level, 1), rtol=1e-9)  # of the quadrature
    power, _ = quad(lambda x: np.clip(x, -level, level) ** 2 * norm.pdf(x), -12, 12, points=[-level, level])
    assert np.isclose(clipped_power(c), power, rtol=1e-9)
    wanted = [part(level, order) for order in (3, 5, 7, 9, 11)]
    np.testing.assert_allclose(hermite_coefficients(c), wanted, atol=1e-9)


@pytest.mark.parametrize("rho", [0.3, 0.8, -0.95])
@pytest.mark.parametrize("level", [1.0, 2.0])
def test_the_orders_add_up_to_the_correlation_of_two_clipped_signals(level: float, rho: float) -> None:
    x = np.linspace(-8, 8, 1601)  # the trapezoid rule of a normal density; its kinks cost 1e-6 at 0.01
    density = norm.pdf(x) * (x[1] - x[0])
    other = np.clip(rho * x + np.sqrt(1 - rho**2) * x[:, None], -level, level)
    wanted = density @ other @ (density * np.clip(x, -level, level))
    c = np.array(level)
    orders = np.concatenate([[bussgang_gain(c)], hermite_coefficients(c)]) ** 2
    left = clipped_power(c) - orders.sum()
    found = orders @ rho ** np.arange(1.0, 12, 2) + left * rho**13
    # What is left beyond order 11, 1e-3 of the power, is given to order 13 as a whole.
    assert np.isclose(found, wanted, atol=5e-4)


def spline(order: int, at: float) -> float:
    """Density of the sum of uniform variables of width 1 about 0: a box convolved with itself."""
    knots = np.arange(order + 1) - order / 2
    return float(np.nan_to_num(BSpline.basis_element(knots, extrapolate=False)(at)))


@pytest.mark.parametrize("level", [2.0, 3.0])
def test_distortion_of_a_flat_band_is_that_band_convolved_with_itself(level: float) -> None:
    setup = rig(1, analyser={"n_lines": 401})
    bare = expected_spectra(chain(beam_system(), setup))
    found = expected_spectra(chain(beam_system(), setup, [Overload(level=level)]))
    ratio = (found.ff / bare.ff).real[0, ::50, 0, 0]
    orders = [1, 3, 5, 7, 9, 11]
    powers = [part(level, order) ** 2 for order in orders]
    # A band from -B to B, sampled at 2.56 B: what lies beyond 1.28 B folds back, band upon band.
    places = np.linspace(0.0, 0.5, 9)  # of 2 B; the box at its very edge counts as inside
    folded = [
        [sum(spline(order, place + 1.28 * m) for m in range(-9, 10)) for order in orders[1:]]
        for place in places
    ]
    wanted = powers[0] + np.array(folded) @ powers[1:]
    # The rms is that of the mean spectrum, the power in it 1/800 less, as 0 Hz counts half: the level is
    # higher by so much; 3e-4 of the power at level 2, and the edge of the band lies half a line off.
    np.testing.assert_allclose(ratio, wanted, rtol=1e-3)


@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
@pytest.mark.parametrize("level", [1.0, 1.5])
def test_clipped_records_have_the_expected_spectra(excitation: str, level: float) -> None:
    averages = 1000
    settings = {"n_lines": 201, "window": "hann", "averages": averages}
    setup = rig(1, 7, 16, excitation=excitation, noise=Noise(1e-3, 1e-3), analyser=settings)
    whole = chain(beam_system(), setup, [Overload(level=level)])
    sampled, wanted = sampled_spectra(whole, np.random.default_rng(3), silent), expected_spectra(whole)
    g2 = coherence(wanted)
    told = g2 > 20 / averages  # below, an estimate of the FRF is no longer near normal
    ratio = np.abs(ESTIMATORS["h1"](sampled) / ESTIMATORS["h1"](wanted))[..., 0]
    assert (np.abs(ratio - 1) < 3 * frf_error(g2, averages))[told].mean() >= 0.99
    # of 201 lines, two and a half of which a Hann window ties
    assert np.isclose((sampled.ff.real / wanted.ff.real).mean(), 1, atol=4 / np.sqrt(averages * 201 / 2.5))
    # Distortion comes in bursts that all lines share: what few peaks a record has make its scatter, not
    # the number of lines. A fifth of the records' power either way, over 1,000 records and three channels.
    lost = sampled.xx * (1 - coherence(sampled)) / (wanted.xx * (1 - g2))
    assert np.isclose(lost.mean(), 1, atol=0.04)


def test_an_overloaded_response_reads_low() -> None:
    setup, h1 = rig(7, analyser={"n_lines": 101}), ESTIMATORS["h1"]
    ideal = h1(expected_spectra(chain(beam_system(), setup)))
    low = h1(expected_spectra(chain(beam_system(), setup, [Overload(Channels(dofs(7)), level=1.0)])))
    gain = 2 * norm.cdf(1.0) - 1
    # by the gain alone: 0 Hz counts half in the power, not in the mean spectrum, up to 0.5 % of the level
    np.testing.assert_allclose(np.abs(low / ideal), gain, rtol=5e-3)


def test_only_the_channels_named_are_clipped() -> None:
    setup = rig(1, 7, analyser={"n_lines": 65})
    bare = expected_spectra(chain(beam_system(), setup))
    found = expected_spectra(chain(beam_system(), setup, [Overload(Channels(dofs(7)), level=1.0)]))
    np.testing.assert_allclose(found.ff, bare.ff, rtol=1e-12)  # rounding
    np.testing.assert_allclose(found.xx[..., 0], bare.xx[..., 0], rtol=1e-9)  # of the largest line
    assert found.xx[..., 1].sum() < 0.6 * bare.xx[..., 1].sum()


def test_a_first_look_sees_what_every_line_sees() -> None:
    setup = rig(1, 7, noise=Noise(1e-3, 1e-3), analyser={"window": "hann"})
    whole = chain(beam_system(), setup, [Overload(level=1.5)])
    every, some = expected_spectra(whole), coarse_spectra(whole, 3)
    # A third of the lines knows the power of sharp resonances to some ten per cent, and with it the level.
    np.testing.assert_allclose(some.ff, every.ff[:, ::3], rtol=0.02)
    assert np.median(np.abs(some.xx / every.xx[:, ::3] - 1)) < 0.15


@pytest.mark.parametrize("excitation", ["impact", "burst_random", "chirp"])
def test_it_is_not_suspected_where_signals_are_not_gaussian(excitation: str) -> None:
    assert Overload.places(beam_system(), rig(1, 7)) == (
        None,
        Channels(dofs(1, 7)),
        Channels(dofs(1)),
        Channels(dofs(7)),
    )
    assert Overload.places(beam_system(), rig(7)) == (None, Channels(dofs(7)))
    assert not Overload.places(beam_system(), rig(1, 7, excitation=excitation))

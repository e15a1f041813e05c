"""What every excitation must be: one signal, on every route to a measurement."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import WINDOWS
from modallab.rig.chain import Chain, chain
from modallab.rig.excitation import EXCITATIONS, ExcitationSetting
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.hammer import pulse_spectrum, pulse_width
from modallab.rig.hardware import Accelerometers, Noise
from modallab.rig.measure import draw
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, rig

KINDS = sorted(EXCITATIONS)
AVERAGES = 100
NOISE = Noise(1e-2, 1e-4)
ROUTES = ("sampled", "drawn")


def suits(kind: str, window: str) -> bool:
    return EXCITATIONS[kind].transient is not None or not WINDOWS[window].transient


WEIGHTINGS = [window for window in WINDOWS if window != "flat_top"]
PAIRS = [(kind, window) for kind in KINDS for window in WEIGHTINGS if suits(kind, window)]


def bench(kind: str, window: str = "rectangular", noise: Noise = NOISE, averages: int = AVERAGES) -> Chain:
    roving = Accelerometers(0.01, roving=True)
    settings = {"frequency_max": 400.0, "n_lines": 201, "window": window, "averages": averages}
    setup = rig(1, 7, 16, noise=noise, accelerometers=roving, analyser=settings)
    excitation = ExcitationSetting(kind, level_scatter=0.2)
    return chain(beam_system(), replace(setup, analyser=replace(setup.analyser, excitation=excitation)))


def made(route: str, whole: Chain, seed: int = 1) -> CrossSpectra:
    rng = np.random.default_rng(seed)
    return sampled_spectra(whole, rng, silent) if route == "sampled" else draw(whole, rng)


@pytest.mark.parametrize("kind", KINDS)
def test_it_says_what_it_is_and_what_it_asks_for(kind: str) -> None:
    excitation = EXCITATIONS[kind]
    assert excitation.summary
    assert 0 <= excitation.continuous <= 1
    assert "level" in excitation.specs()
    for name, spec in excitation.specs().items():
        assert spec.unit, name
        assert spec.doc, name
        assert spec.lower <= getattr(ExcitationSetting(kind), name) <= spec.upper, name


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_out_of_bounds_is_refused_by_name(kind: str) -> None:
    for name, spec in EXCITATIONS[kind].specs().items():
        for wrong in (spec.lower - 1e-3, spec.upper * 1.01, np.nan):
            with pytest.raises(InvalidInputError) as caught:
                replace(ExcitationSetting(kind), **{name: wrong})  # type: ignore[arg-type]
            assert caught.value.context["field"] == f"excitation.{name}"


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize(("kind", "window"), PAIRS)
def test_every_route_agrees_with_the_expected_spectra_within_the_random_error(
    kind: str, window: str, route: str
) -> None:
    whole = bench(kind, window)
    expected = expected_spectra(whole)
    g2 = coherence(expected)
    h, told = [], g2 > 5 / AVERAGES  # below some 1/n_d the printed error of a coherence means nothing
    coherent, powers = [], []
    # Exponential windows tie neighbouring lines together: 400 values are worth a third as many.
    for seed in range(4 if WINDOWS[window].end < 1 else 1):
        found = made(route, whole, seed)
        ratio = np.abs(ESTIMATORS["h1"](found) / ESTIMATORS["h1"](expected))[..., 0]
        h.append(np.abs(ratio - 1) < 3 * frf_error(g2, AVERAGES))
        coherent.append((np.abs(coherence(found) / g2 - 1) < 3 * coherence_error(g2, AVERAGES))[told])
        pairs = (found.ff.real, expected.ff.real), (found.xx, expected.xx)
        powers += [np.abs(one / other - 1) < 3 / np.sqrt(AVERAGES) for one, other in pairs]
    assert np.mean(h) >= 0.99  # 0.997 if normal
    # skew where coherence is near 1; of a leaking signal records that follow one another share what leaks
    leaks = EXCITATIONS[kind].continuous > 0
    assert np.mean(coherent) >= (0.97 if leaks else 0.98)
    within = np.concatenate([part.ravel() for part in powers])
    assert within.mean() >= (0.97 if leaks else 0.99)  # 0.997 if Gaussian, less scatter if it comes back


@pytest.mark.parametrize("kind", KINDS)
def test_its_power_at_low_frequency_is_that_of_its_level(kind: str) -> None:
    whole = bench(kind, noise=Noise())
    analyser = whole.setup.analyser
    force = expected_spectra(whole).ff[:, 1:20, 0, 0].real
    # lines of a signal that leaks, or ends in the record, see the edge of the band: 0.1 %
    np.testing.assert_allclose(force, analyser.source_level**2 / analyser.frequency_max, rtol=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_its_force_is_flat_over_the_band_or_falls_as_its_pulse_does(kind: str) -> None:
    whole = bench(kind, noise=Noise())
    force = expected_spectra(whole).ff[:, 1:, 0, 0].real
    # lines of a random signal have half a neighbourhood at the top of the band
    flat, freq = force[:, :-8] / force[:, :1], whole.setup.analyser.freq[1:-8]
    setting = whole.setup.analyser.excitation
    width = pulse_width(setting.tip_stiffness, setting.hammer_mass)
    shape = np.abs(pulse_spectrum(2 * np.pi * freq, width)) ** 2 if kind == "impact" else np.ones_like(freq)
    # records cut off what the edge of the band does to white noise, and the filter's ringing of a pulse
    np.testing.assert_allclose(flat, np.tile(shape, (len(flat), 1)), rtol=1e-2)


@pytest.mark.parametrize("kind", KINDS)
def test_twice_the_level_is_four_times_the_power_and_the_same_frf(kind: str) -> None:
    whole = bench(kind)
    louder = replace(whole.setup.analyser.excitation, level=2.0)
    setup = replace(whole.setup, analyser=replace(whole.setup.analyser, excitation=louder))
    once, twice = expected_spectra(whole), expected_spectra(chain(beam_system(), setup))
    np.testing.assert_allclose(twice.ff, 4 * once.ff, rtol=1e-12)  # rounding
    np.testing.assert_allclose(ESTIMATORS["h1"](twice), ESTIMATORS["h1"](once), rtol=1e-9)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_bytes(kind: str, route: str) -> None:
    whole = bench(kind, averages=5)
    a, b, c = (made(route, whole, seed) for seed in (1, 1, 2))
    assert a.fx.tobytes() == b.fx.tobytes() != c.fx.tobytes()
    assert a.ff.tobytes() == b.ff.tobytes()


@pytest.mark.parametrize("kind", [kind for kind in KINDS if EXCITATIONS[kind].phases is not None])
@pytest.mark.parametrize("route", ROUTES)
def test_a_force_that_is_the_same_every_time_does_not_scatter(kind: str, route: str) -> None:
    whole = bench(kind, noise=Noise())
    expected, found = expected_spectra(whole), made(route, whole)
    # rounding of sums, and of transforms relative to the largest line, 1e5 above the smallest
    np.testing.assert_allclose(found.ff, expected.ff, rtol=1e-9)
    np.testing.assert_allclose(coherence(found), 1.0, rtol=1e-9)
    exact = ESTIMATORS["h1"](expected)
    np.testing.assert_allclose(ESTIMATORS["h1"](found), exact, rtol=1e-8, atol=1e-10 * np.abs(exact).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_first_look_sees_the_same_lines(kind: str) -> None:
    whole = bench(kind)
    quick, full = coarse_spectra(whole, 4), expected_spectra(whole)
    # exact but where it leaks: four Gauss points a line
    tolerance = 0.3 if EXCITATIONS[kind].continuous else 1e-2
    force: FloatArray = quick.ff.real / full.ff[:, ::4].real
    np.testing.assert_allclose(force, 1.0, rtol=tolerance)


@pytest.mark.parametrize("kind", KINDS)
def test_the_memory_of_a_sampled_test_does_not_grow_with_the_averages(kind: str) -> None:
    peaks = []
    for averages in (400, 4000):
        settings = {"n_lines": 101, "averages": averages}
        whole = chain(beam_system(), rig(1, 11, excitation=kind, noise=NOISE, analyser=settings))
        expected_spectra(whole)  # what is kept for the next time is not counted
        tracemalloc.start()
        sampled_spectra(whole, np.random.default_rng(1), silent)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]  # averages are shared out to equal batches, a tenth longer or shorter

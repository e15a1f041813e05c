"""Tests of levels that no log book declares: noise, and the source's spectrum."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.channel_noise import ChannelNoise, noise_functions
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.residuals.source_power import shape_variance, source_functions
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching.suspects import suspected
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.extra_mass import ExtraMass
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise, NoiseDensity
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, rig

FORCE, RESPONSE = 3e-6, 2e-5  # N^2/Hz, (m/s^2)^2/Hz; 0.1 % of the force of 5 N
UNKNOWN = Noise(None, None)


def declared(kind: str = "periodic_random", window: str = "rectangular", *, roving: bool = True) -> RigSetup:
    setup = rig(kind=kind, window=window, roving=roving)
    source = ExcitationSetting(kind, level=5.0)
    noise = Noise(NoiseDensity(FORCE), NoiseDensity(RESPONSE))
    return replace(setup, noise=noise, analyser=replace(setup.analyser, excitation=source))


def undeclared(test: Measurement, *, source: bool = True) -> Measurement:
    setup = replace(test.setup, noise=UNKNOWN)
    if source:
        unknown = replace(setup.analyser.excitation, level=None, shape="unknown")
        setup = replace(setup, analyser=replace(setup.analyser, excitation=unknown))
    return replace(test, setup=setup)


def measured(setup: RigSetup, hidden: tuple[Effect, ...] = (), seed: int = 1) -> Measurement:
    return measure(model(), setup, hidden, route=Route.DRAWN, rng=np.random.default_rng(seed))


def predictor_of(test: Measurement) -> SingleTestPredictor:
    return SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))


@pytest.mark.parametrize("roving", [True, False])
def test_fitted_noise_is_that_of_the_channels(roving: bool) -> None:
    predictor = predictor_of(undeclared(measured(declared(roving=roving)), source=False))
    observed, expected = predictor.observed, expected_spectra(predictor.chain(()))
    noise = observed.free_levels.fitted_noise(expected, observed)
    assert noise is not None
    # 160 lines of 100 averages: 1 % of a response's mean level; the force's shows in few of them
    freq = observed.freq[1:]
    assert noise.force_at(freq).mean() == pytest.approx(FORCE, rel=0.2)
    np.testing.assert_allclose(np.mean(noise.response_at(freq), axis=0), RESPONSE, rtol=0.2)


def test_fitted_noise_is_finite_where_a_cost_is_not() -> None:
    # A predicted auto spectrum below zero has no logarithm: the fit ends where it started.
    predictor = predictor_of(undeclared(measured(declared(roving=False)), source=False))
    observed, expected = predictor.observed, expected_spectra(predictor.chain(()))
    xx, fx = expected.xx.copy(), expected.fx.copy()
    xx[..., 2], fx[..., 2] = -1e-16 * xx.max(), 0.0
    n = noise_functions(observed.freq, observed.freq).shape[1]
    response = np.tile(np.where(np.arange(xx.shape[2]) == 2, -np.inf, np.log(RESPONSE)), (n, 1))
    no_noise = ChannelNoise(observed.freq, np.full(n, np.log(FORCE)), response)
    with np.errstate(invalid="ignore"):
        noise = observed.free_levels.fitted_noise(replace(expected, xx=xx, fx=fx), observed, start=no_noise)
    assert noise is not None
    assert np.isfinite(noise.force_at(observed.freq)).all()
    assert np.isfinite(noise.response_at(observed.freq)).all()


@pytest.mark.parametrize("roving", [True, False])
def test_fitted_noise_does_not_depend_on_where_its_fit_starts(roving: bool) -> None:
    predictor = predictor_of(undeclared(measured(declared(roving=roving)), source=False))
    levels, expected = predictor.observed.free_levels, expected_spectra(predictor.chain(()))
    noise = levels.fitted_noise(expected, predictor.observed)
    assert noise is not None
    assert noise.force is not None
    assert noise.response is not None
    near = ChannelNoise(noise.measured, noise.force + np.log(3), noise.response - np.log(2))
    again = levels.fitted_noise(expected, predictor.observed, start=near)
    assert again is not None
    freq = predictor.observed.freq[1:]
    # a fit ends at a relative gain of 1e-13: the square root of that, times the condition of two spectra
    np.testing.assert_allclose(again.force_at(freq), noise.force_at(freq), rtol=1e-4)
    np.testing.assert_allclose(again.response_at(freq), noise.response_at(freq), rtol=1e-5)


def test_the_power_of_a_source_is_the_weighted_least_squares_solution() -> None:
    predictor = predictor_of(undeclared(measured(declared())))
    observed, expected = predictor.observed, expected_spectra(predictor.chain(()))
    assert observed.force is not None
    powered = observed.free_levels.with_source(expected, observed)
    basis = source_functions(observed.freq, observed.freq, shape=True)
    used = observed.usable.any(axis=1) & ~observed.held_out_lines
    variance = np.broadcast_to(observed.force_variance, observed.force.shape)
    for run, (before, after) in enumerate(zip(expected.ff, powered.ff, strict=True)):
        weight = 1 / np.sqrt(variance[used, run])
        ratio = np.log(observed.force[used, run] / before[used, 0, 0].real)
        curve = np.linalg.lstsq(weight[:, None] * basis[used], weight * ratio, rcond=None)[0]
        # solved once by the pseudoinverse, once for each run: rounding alone differs
        np.testing.assert_allclose(after[:, 0, 0] / before[:, 0, 0], np.exp(basis @ curve), rtol=1e-9)


@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
def test_an_exact_model_is_explained_whatever_the_levels(kind: str, window: str) -> None:
    predictor = predictor_of(undeclared(measured(declared(kind, window))))
    gaps = predictor.residual(()).gaps(predictor.observed.usable)
    # 6 x 160 lines: 5 % of real squares; 8 splines a run take up 5 % of the force
    assert all(0.75 < gap < 1.2 for gap in gaps.values())


def test_a_source_with_a_smooth_spectrum_of_its_own_leaves_no_force_gap() -> None:
    test = measured(declared())
    assert test.force_spectrum is not None
    assert test.response_spectrum is not None
    colour = 10 ** (1.5 * np.cos(np.pi * np.arange(161) / 160))  # 30 dB from end to end
    coloured = replace(
        test,
        force_spectrum=test.force_spectrum * colour[:, None, None],
        response_spectrum=test.response_spectrum * colour[:, None],
    )
    predictor = predictor_of(undeclared(coloured))
    gaps = predictor.residual(()).gaps(predictor.observed.usable)
    assert gaps["force"] < 1.2  # 6 x 160 lines scatter by 5 %
    predictor = predictor_of(replace(coloured, setup=test.setup))
    assert predictor.residual(()).gaps(predictor.observed.usable)["force"] > 100


def test_levels_are_the_best_fit_so_that_no_other_level_is_better() -> None:
    predictor = predictor_of(undeclared(measured(declared()), source=False))
    observed, expected = predictor.observed, expected_spectra(predictor.chain(()))
    best = residual(observed, predictor.predict(())).gap(observed.fitted)
    for factor in (0.97, 1.03):
        shifted = Noise(NoiseDensity(FORCE * factor), NoiseDensity(RESPONSE * factor))
        other = replace(predictor, setup=replace(predictor.setup, noise=shifted))
        fixed = replace(other, observed=replace(observed, free_levels=type(observed.free_levels)()))
        assert fixed.residual(()).gap(observed.fitted) > best
    assert np.isfinite(expected.xx).all()


@pytest.mark.parametrize(
    "hidden", [ExtraMass(at=Dof.parse("4:+Y"), mass=0.05), ExciterArmature(mass=0.1)], ids=lambda e: e.kind
)
def test_the_same_effect_is_named_as_with_declared_levels(hidden: Effect) -> None:
    kinds = ["extra_mass", "exciter_armature", "force_noise", "response_noise", "quantisation"]
    test = measured(declared(), (hidden,))
    known = diagnose(model(), test, suspects=kinds)
    unknown = diagnose(model(), undeclared(test), suspects=kinds)
    for diagnosis in (known, unknown):
        assert [step.effect.kind for step in diagnosis.steps] == [hidden.kind]
        (mass,) = diagnosis.steps[0].effect.parameters.values()
        assert mass.value == pytest.approx(hidden.parameters["mass"], abs=4 * mass.standard_error)


def test_noise_that_was_never_declared_is_not_judged() -> None:
    test = undeclared(measured(declared()))
    kinds = {effect.kind for effect in suspected(predictor_of(test), None)}
    assert not kinds & {"force_noise", "response_noise", "quantisation"}
    diagnosis = diagnose(model(), test)
    assert diagnosis.verdict is Verdict.NOTHING_MISSING
    assert any("not judged" in note for note in diagnosis.notes)


def test_lines_outside_the_source_band_take_no_part() -> None:
    test = measured(declared())
    source = replace(test.setup.analyser.excitation, band=(100.0, 300.0))
    setup = replace(test.setup, analyser=replace(test.setup.analyser, excitation=source))
    observed = observe(replace(test, setup=setup), (), fraction=0.25)
    used = observed.freq[observed.usable.any(axis=1)]
    assert used[0] == pytest.approx(100.0)
    assert used[-1] == pytest.approx(300.0)


@pytest.mark.parametrize(("ripple", "variance"), [(0.0, 0.0), (0.002, 0.002**2 / 2), (0.2, 0.023**2)])
def test_variance_of_unknown_shape_is_that_beside_smooth_curves_up_to_a_tenth_of_a_decibel(
    ripple: float, variance: float
) -> None:
    freq = np.linspace(2.0, 800.0, 400)
    pulse = np.exp(-((freq / 600.0) ** 2)) * (1 + ripple * np.sin(freq / 5))
    usable = np.ones((len(freq), 1), bool)
    # Eight splines take up little of a fast sine, and leave 1e-8 of so smooth a pulse.
    assert shape_variance(freq, pulse[:, None], usable) == pytest.approx(variance, rel=0.1, abs=1e-7)


def _with_noise(test: Measurement, noise: FloatArray, rng: np.random.Generator) -> Measurement:
    """An exact test with noise (n_freq, n_out), (m/s^2)^2/Hz, in the responses, over the test's averages."""
    assert test.force_spectrum is not None
    assert test.response_spectrum is not None
    n, h, force = int(test.averages), test.frf.values[..., 0], test.force_spectrum[..., 0]
    scatter = rng.standard_normal((2, *h.shape)) * np.sqrt(noise / force / (2 * n))
    measured = h + scatter[0] + 1j * scatter[1]
    coherent = force * np.abs(measured) ** 2
    power = coherent + noise * rng.gamma(n - 1, 1 / n, noise.shape)
    return replace(
        test,
        frf=replace(test.frf, values=measured[..., None]),
        coherence=coherent / np.maximum(power, 1e-300),
        response_spectrum=power,
        route=None,
        setup=replace(test.setup, noise=Noise(None, None)),
    )


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_noise_of_any_colour_that_nobody_declared_is_no_missing_effect(exponent: float) -> None:
    """Accelerometers and amplifiers have noise that falls with frequency: it was named a hardening spring."""
    exact = draw_measurement(rig(noise=0.0))
    assert exact.force_spectrum is not None
    signal = np.abs(exact.frf.values[..., 0]) ** 2 * exact.force_spectrum[..., 0]
    freq = exact.frf.freq[:, None]
    colour = (np.maximum(freq, freq[1]) / np.median(freq)) ** -exponent
    test = _with_noise(exact, 1e-4 * signal.mean(axis=0) * colour, np.random.default_rng(0))
    assert diagnose(model(), test).verdict is Verdict.NOTHING_MISSING

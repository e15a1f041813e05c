"""Forces that are no straight lines as suspects: looked for, predicted however strong, named."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.covariance import ParameterErrors
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.reporting.text import number_text
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.predicted import VarianceRatios
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.acceptance import is_significant
from modallab.diagnosis.searching.gap_tests import is_noise_only, unexplained_parts
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.fe.assembly import assemble
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import Noise
from modallab.rig.measure import measurement_of
from modallab.rig.sampled import sampled_spectra
from modallab.rig.simulated_variance import SimulatedVariance
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE
from tests.diagnosing import draw_measurement, model, predicting, rig

CUBIC = CubicStiffness(Dof(4, "Y"), 3e9)
RUBBING = Friction(Dof(5, "Y"), 0.01)
KINDS = ("cubic_stiffness", "friction", "ground_spring", "local_damping", "response_noise")


@pytest.mark.parametrize("effect", [CUBIC, RUBBING], ids=lambda effect: effect.kind)
@pytest.mark.parametrize("declared", [True, False], ids=["noise declared", "noise unknown"])
def test_they_are_looked_for_where_no_response_spectrum_was_stored(effect: Effect, declared: bool) -> None:
    """The coherence shows them where the log book declares the noise."""
    measured = replace(draw_measurement(rig(), [effect]), force_spectrum=None, response_spectrum=None)
    if not declared:
        measured = replace(measured, setup=replace(measured.setup, noise=Noise(None, None)))
    evidence = collect_evidence(predicting(measured)[0], [])
    assert (evidence.response is not None) is declared
    assert type(effect).signature(evidence) > DIAGNOSIS.least_suspicion


@pytest.mark.parametrize("effect", [CUBIC, RUBBING], ids=lambda effect: effect.kind)
def test_a_response_spectrum_that_disagrees_lets_them_be_looked_for(effect: Effect) -> None:
    """Also where friction takes more of what the force's noise makes at resonances than it adds itself."""
    distorted, bare = (
        collect_evidence(predicting(draw_measurement(rig(), added))[0], []) for added in ([effect], [])
    )
    assert type(effect).signature(distorted) > DIAGNOSIS.least_suspicion
    # by chance a mean over a thousand lines is 0.03 off
    assert type(effect).signature(bare) < type(effect).signature(distorted) / 2


@pytest.mark.parametrize("kind", ["periodic_random", "random"])
@pytest.mark.parametrize("size", [1e-3, 1e9, 1e15, 1e24])
def test_a_candidate_of_any_size_is_predicted_though_a_measurement_would_be_refused(
    kind: str, size: float
) -> None:
    setup = rig(kind=kind, window="rectangular" if kind == "periodic_random" else "hann")
    predictor, _ = predicting(draw_measurement(setup))
    for predicted in (
        predictor.predict([CubicStiffness(Dof(4, "Y"), size)]),
        predictor.coarse_prediction([]).predict([CubicStiffness(Dof(4, "Y"), size)]),
    ):
        assert np.isfinite(predicted.h).all()
        assert (predicted.incoherent[1:] > 0).all()
        assert ((predicted.coherence >= 0) & (predicted.coherence <= 1 + 1e-9)).all()


@pytest.mark.parametrize("effect", [CUBIC, RUBBING], ids=lambda effect: effect.kind)
def test_they_are_named_with_place_and_size_among_what_looks_like_them(effect: Effect) -> None:
    found = diagnose(model(), draw_measurement(rig(), [effect], seed=3), suspects=KINDS, max_effects=1)
    first = found.steps[0].effect
    assert (first.kind, first.at) == (effect.kind, effect.at)
    name = next(iter(effect.specs()))
    fitted = first.parameters[name]
    # four standard errors hold all but 6e-5; the fit itself ends within a thousandth of its goal
    assert abs(fitted.value - effect.parameters[name]) < 4 * fitted.standard_error + 1e-3 * fitted.value


def test_the_stated_error_of_a_cubic_spring_holds_though_its_distortion_comes_in_bursts() -> None:
    setup = rig(roving=False, noise=1e-3)
    whole = chain(assemble(model()), setup, [CUBIC])
    off = []
    for seed in range(3):
        spectra = sampled_spectra(whole, np.random.default_rng(seed), silent)
        found = fit(predicting(measurement_of(spectra, setup))[0], [CUBIC])
        fitted = found.effects[0].parameters["stiffness"]
        off.append((fitted - CUBIC.stiffness) / found.errors[0]["stiffness"])
    # the error itself is known from four tests: three such ratios are within this nine times in ten
    assert np.sqrt(np.mean(np.square(off))) < 2.0


def test_simulated_tests_serve_every_predictor_of_a_test() -> None:
    """One search follows another under other tolerances: the same force is stepped through time once."""
    test, known = draw_measurement(rig(roving=False, kind="random"), [CUBIC]), SimulatedVariance()
    observed = observe(test, (), fraction=0.0)
    for _ in range(2):
        predictor = SingleTestPredictor.of(model(), test.setup, observed)
        replace(predictor, simulated=known).with_intermittent_errors([CUBIC])
    assert known.n_simulated == SIMULATED_VARIANCE.n_stepped_tests


def test_wider_errors_pay_for_what_they_forgive() -> None:
    """Minus twice the logarithm of a Gaussian likelihood: squares, and logarithms of variances."""
    predictor, observed = predicting(draw_measurement(rig(roving=False), [CUBIC]))
    fixed = fit(predictor, [], fixed=[CUBIC])
    wide = predictor.with_intermittent_errors([CUBIC]).observed
    assert wide.incoherent_variance is not None
    assert observed.incoherent_variance is not None
    assert observed.force is not None
    vector = residual(wide, predictor.predict([CUBIC])).vector(wide.fitted)
    factors = (
        2 * np.log((wide.error / observed.error)[observed.fitted] ** 2).sum()
        + np.log((wide.incoherent_variance / observed.incoherent_variance)[observed.fitted]).sum()
        + np.log(np.divide(wide.force_variance, observed.force_variance)[observed.fitted.any(axis=1)]).sum()
    )
    assert factors > 0
    assert fixed.chi_square == pytest.approx(vector @ vector + factors, rel=1e-9)


@pytest.mark.parametrize(("times", "explained"), [(1.0, True), (10.0, False), (300.0, False)])
def test_errors_far_wider_than_the_residuals_explain_nothing(times: float, explained: bool) -> None:
    """A force so strong that its bursts forgive any response spectrum has not predicted that spectrum."""
    measured = draw_measurement(rig(roving=False), [CUBIC], seed=3)
    predictor = SingleTestPredictor.of(model(), measured.setup, observe(measured, (), fraction=0.25))
    before, found = fit(predictor, []), fit(predictor, [CUBIC])
    assert found.residual.variance_ratios is not None
    own = found.residual.variance_ratios()
    wide = VarianceRatios(own.force, own.frf, own.response * times)
    candidate = replace(found, residual=replace(found.residual, variance_ratios=lambda: wide))
    assert unexplained_parts(predictor, candidate, max_lag=None) == (set() if explained else {"response"})
    assert is_noise_only(predictor, candidate) == explained
    assert is_significant(predictor, before, candidate) == explained


def test_errors_are_as_they_were_where_nothing_comes_in_bursts() -> None:
    predictor, _ = predicting(draw_measurement(rig()))
    assert predictor.with_intermittent_errors([]).observed is predictor.observed


def test_a_force_whose_size_is_known_to_a_factor_only_is_accepted_all_the_same() -> None:
    """What the size scatters by through bursts says nothing against the likelihood of the force itself."""
    strong = CubicStiffness(Dof(4, "Y"), 1e10)
    measured = draw_measurement(rig(roving=False), [strong])
    predictor = SingleTestPredictor.of(model(), measured.setup, observe(measured, (), fraction=0.2))
    after = fit(predictor, [strong])
    vague = ParameterErrors(({"stiffness": strong.stiffness},), np.zeros(0))
    assert is_significant(predictor, fit(predictor, []), replace(after, compute_errors=lambda: vague))


def test_a_force_that_grows_with_the_level_is_named_without_a_size_where_nothing_tells_the_level() -> None:
    setup = rig(roving=False)
    excitation = replace(setup.analyser.excitation, level=None)
    undeclared = replace(setup, analyser=replace(setup.analyser, excitation=excitation))
    measured = replace(draw_measurement(setup, [CUBIC]), force_spectrum=None, response_spectrum=None)
    diagnosis = diagnose(model(), replace(measured, setup=undeclared), suspects=["cubic_stiffness"])
    effect = diagnosis.steps[0].effect
    assert (effect.kind, effect.at) == ("cubic_stiffness", CUBIC.at)
    assert np.isnan(effect.parameters["stiffness"].value)
    assert number_text(effect.parameters["stiffness"]) == "needs a level"
    assert any("needs a level" in note for note in diagnosis.notes)

"""Residuals of records that leak, of forces that come back, at low coherence: judged by how they scatter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.residuals.normalised_difference import normalised_difference
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual, gap_errors
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.effects.exciter_armature import ExciterArmature
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, predicting, rig

SEEDS = 24


@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_with_nothing_missing_the_gap_of_leaking_records_is_one_within_its_scatter(window: str) -> None:
    setup = rig(kind="random", window=window)
    gaps, stated, plain = [], [], []
    for seed in range(SEEDS):
        measurement = measure(model(), setup, route=Route.SAMPLED, rng=np.random.default_rng(seed))
        predictor, observed = predicting(measurement)
        nothing = fit(predictor, ())
        left = nothing.residual
        gaps.append(left.gaps(observed.usable)["response"])
        stated.append(gap_errors(observed, left, observed.usable)["response"])
        plain.append(replace(left, excess_variance=None).gaps(observed.usable)["response"])
        assert is_noise_only(predictor, nothing)
    allowed = 4 * np.mean(stated) / np.sqrt(SEEDS)  # four standard errors of the mean
    assert abs(np.mean(gaps) - 1) < allowed
    # a standard deviation of 24 is known to 1/sqrt(48) = 14 %: three of these
    assert np.std(gaps) == pytest.approx(np.mean(stated), rel=0.43)
    if window == "rectangular":  # records that end where the next begin: without the factor it fails
        assert np.mean(plain) - 1 > 2 * allowed


def test_signals_that_repeat_with_the_record_need_no_factor() -> None:
    predictor, _ = predicting(draw_measurement(rig()))
    left: Residual = predictor.residual(())
    assert left.excess_variance is None
    assert left.rescaled["response"] is left.response


def _hammered(setup: RigSetup) -> RigSetup:
    return replace(setup, exciter=Exciter(kind="hammer"), force_transducer=ForceTransducer())


@pytest.mark.parametrize(
    ("setup", "estimate"),
    [
        (rig(kind="chirp", noise=1e-3), 0.35),
        (rig(kind="pseudo_random", noise=1e-2, averages=20), 0.35),
        (_hammered(rig(kind="impact", noise=1e-4)), 0.35),
        (replace(rig(kind="chirp"), noise=Noise(0.1, 1e-4)), 1.0),
    ],
    ids=["chirp", "pseudo-random", "blows", "much noise in the force"],
)
def test_forces_that_come_back_are_judged_by_their_noise_alone(setup: RigSetup, estimate: float) -> None:
    gaps: dict[str, list[float]] = {}
    weighed, gaussian = [], []
    n = setup.analyser.simulated_averages
    for seed in range(6):
        measurement = measure(model(), setup, route=Route.SAMPLED, rng=np.random.default_rng(seed))
        predictor, observed = predicting(measurement)
        nothing = fit(predictor, ())
        left = nothing.residual
        for part, gap in left.gaps(observed.usable).items():
            gaps.setdefault(part, []).append(gap)
        assert is_noise_only(predictor, nothing)
        plain = replace(left, variance_ratios=None)
        weighed.append(plain.gaps(observed.usable)["force"])
        anew = replace(plain, force=left.force * np.sqrt(left.force_variance * n))
        gaussian.append(anew.gaps(observed.usable)["force"])
    for part, found in gaps.items():
        # 6 tests of 960 lines: 2 % of real squares; four of these, and what is beyond first order at 20
        assert np.mean(found) == pytest.approx(1.0, abs=0.08 + 1 / n), part
    # a fit knows the noise from coherence alone, where responses have theirs too: a bound
    assert estimate * 0.6 < np.mean(weighed) < estimate * 1.6
    # as records drawn anew scatter, a misfit could hide there
    assert np.mean(gaussian) < 0.25


def test_an_armature_shows_in_a_force_that_comes_back_long_before_it_does_in_a_random_one() -> None:
    forces = []
    for kind in ("periodic_random", "chirp"):
        measurement = measure(
            model(),
            rig(kind=kind, noise=1e-4),
            [ExciterArmature(mass=0.0004)],
            route=Route.SAMPLED,
            rng=np.random.default_rng(1),
        )
        predictor, observed = predicting(measurement)
        forces.append(predictor.residual(()).gaps(observed.usable)["force"])
    assert forces[0] < 1.5  # 0.4 g of 20 g: within a random force's scatter of 10 %
    assert forces[1] > 10


LINES = 20_000


def _drawn_at(g2: float, averages: int) -> Observed:
    """Return what is seen of 20,000 lines where H is 1 and coherence is g2, drawn by Bartlett's factors."""
    rng = np.random.default_rng(3)
    force = rng.standard_gamma(averages, LINES) / averages
    loose = (1 - g2) / g2
    noise = rng.standard_normal((LINES, 2)).view(complex)[:, 0] / np.sqrt(2)
    h = 1 + np.sqrt(loose / (averages * force)) * noise
    left = loose * rng.standard_gamma(averages - 1, LINES) / averages
    explained = np.abs(h) ** 2 * force
    found = explained / (explained + left)
    setup = replace(
        rig(averages=averages),
        responses=(Dof(1, "Y"),),
        analyser=Analyser(frequency_max=400.0, n_lines=LINES + 1, averages=averages),
    )
    frf = FrfSet(setup.analyser.freq[1:], h[:, None, None], setup.responses, setup.drives, FrfKind.INERTANCE)
    return observe(Measurement(frf, found[:, None], averages, setup), (), fraction=0.0)


@pytest.mark.parametrize("averages", [10, 30, 100])
@pytest.mark.parametrize("g2", [0.05, 0.1, 0.3, 0.5, 0.9])
def test_lines_of_any_coherence_are_weighed_rightly_and_bias_no_fit(g2: float, averages: int) -> None:
    observed = _drawn_at(g2, averages)
    ones = np.ones_like(observed.h)
    left = normalised_difference(observed, ones) / (np.sqrt(2) * observed.error)
    squares = (np.abs(left[observed.usable]) ** 2).mean()
    # F-distributed squares of 20,000 lines: sqrt(1 + 2/7)/141 = 0.8 % at 10 averages; three of these, and
    # 1 % where logarithm and difference meet
    assert squares == pytest.approx(1.0, abs=0.035)

    def cost(gain: float) -> float:
        off = normalised_difference(observed, np.exp(gain) * ones) / observed.error
        return float((np.abs(off) ** 2).sum())

    gain = minimize_scalar(cost, bracket=(-0.1, 0.1)).x
    one_line = np.sqrt((1 - g2) / (2 * averages * g2))
    # the mean of 20,000 lines is known to 0.7 % of one line's error; three of these, and where they meet 3 %
    assert abs(gain) < (0.021 + 0.03) * one_line


@pytest.mark.parametrize("noise", [1e-4, 1e-2])
def test_noise_of_the_force_that_all_channels_share_is_counted_once(noise: float) -> None:
    setup = rig(roving=False, noise=noise)
    n_out, before, after, total = len(setup.responses), [], [], []
    for seed in range(4):
        test = measure(model(), setup, [], route=Route.SAMPLED, rng=np.random.default_rng(seed))
        predictor, observed = predicting(test)
        left = predictor.residual([])
        vector = left.vector(observed.fitted)
        lines = int(observed.fitted.sum())
        parts = vector[: 2 * lines].reshape(2, -1, n_out)
        after.append(n_out * float((parts.mean(axis=2) ** 2).mean()))
        before.append(n_out * float((np.abs(left.frf[1:].mean(axis=1)) ** 2).mean()))
        total.append(float(vector @ vector) / len(vector))
    assert np.mean(before) > 1.4, "what channels share weighs more than what each has alone"
    # 4 tests of 320 numbers scatter by 4 %; the share is estimated from the same data to some 10 %.
    assert np.mean(after) == pytest.approx(1.0, abs=0.15)
    assert np.mean(total) == pytest.approx(1.0, abs=0.03)

"""Draws from the posterior: those of the density itself, and of its straight line where that is straight."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import MissingExtraError, UnderdeterminedError
from modallab.fe.assembly import Assembly
from modallab.fe.beam import beam
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Material, Section
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.log_coefficients import from_log_changes, log_changes
from modallab.updating.method import UPDATERS
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.one_stage_path import OneStagePath, OneStageRule, correct
from modallab.updating.options import OneStageOptions
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.posterior import PosteriorSample
from modallab.updating.sampling import sample
from modallab.updating.sparse_bayes import Prior
from modallab.updating.target import real_modes
from tests.service.updating.cases import modes_of

# Small: a draw is an eigen-solution.
MODEL = beam(length=1.5, n_elements=6, section=Section(5e-4, 4.1667e-9), material=Material(2.09e11, 7800.0))
DOFS = tuple(Dof(node, "Y") for node in range(1, 8))
TRUTH = change(MODEL, [MemberChange((3, 4), MemberProperty.MODULUS, factor=1.3)])
THIRDS = [(1, 2), (3, 4), (5, 6)]
SOME = ModeNoise(eigenvalue=0.005, eigenvector=0.05)


def path(
    parameters: Parameterisation, noise: ModeNoise, prior: Prior = Prior.RANGE
) -> tuple[ModalResiduals, OneStagePath]:
    target = real_modes(modes_of(TRUTH, 5, DOFS, noise, seed=4))
    fit = ModalResiduals(Assembly(MODEL), parameters, target, 0.0)
    return fit, correct(fit, OneStageRule(prior, 1e-8, 30, 1e3))


def drawn(fit: ModalResiduals, whole: OneStagePath, n: int = 4000, seed: int = 1) -> PosteriorSample:
    return sample(fit, whole, n, seed)


def test_draws_of_one_coefficient_are_those_of_its_density_by_quadrature() -> None:
    # one member is seen by one mode alone: a density with a long tail
    parameters = parameterise([(3,)], ("stiffness",))
    target = real_modes(modes_of(TRUTH, 1, DOFS[:2], ModeNoise(eigenvalue=0.02), seed=4))
    fit = ModalResiduals(Assembly(MODEL), parameters, target, 0.0)
    whole = correct(fit, OneStageRule(Prior.RANGE, 1e-8, 30, 1e3))
    found = drawn(fit, whole, 1600)
    grid = np.linspace(np.log(0.05), np.log(10.0), 301)
    belief, final = whole.posterior, whole.iterations.final
    unit = final.size * whole.weights.units * np.sqrt(belief.block_variances[whole.weights.block])
    misfit = np.array(
        [
            ((fit.state(from_log_changes(parameters, np.array([x]))).difference / unit) ** 2).sum()
            for x in grid
        ]
    )
    density = np.exp(-0.5 * (misfit - misfit.min() + grid**2 / belief.prior_variances[0]))
    density /= density.sum()
    mean = (density * grid).sum()
    deviation = np.sqrt((density * (grid - mean) ** 2).sum())
    own = np.log(found.draws[:, 0])
    n = float(found.effective[0])
    assert n > 100
    # four standard errors of a mean; of a standard deviation, with tails that may be twice a normal one's
    assert abs(own.mean() - mean) < 4 * deviation / np.sqrt(n)
    assert abs(own.std() / deviation - 1) < 8 / np.sqrt(2 * n)
    # and it is no normal one: the straight line has another width
    assert abs(belief.errors[0] / deviation - 1) > 0.02


def test_where_errors_are_small_draws_are_those_of_the_straight_line() -> None:
    parameters = parameterise(THIRDS)
    fit, whole = path(parameters, ModeNoise(eigenvalue=1e-4, eigenvector=1e-3))
    found = drawn(fit, whole, 2400)
    own = np.array([log_changes(parameters, one) for one in found.draws])
    errors, n = whole.posterior.errors, found.effective
    assert (n > 100).all()
    assert (np.abs(own.mean(axis=0) - whole.posterior.mean) < 4.5 * errors / np.sqrt(n)).all()
    np.testing.assert_allclose(own.std(axis=0), errors, rtol=float(4.5 / np.sqrt(2 * n.min())))
    correlations = whole.posterior.covariance / np.outer(errors, errors)
    # 4.5 standard errors of a correlation, at most
    assert np.abs(np.corrcoef(own.T) - correlations).max() < 4.5 / np.sqrt(n.min())
    assert 0.1 < found.acceptance < 0.9


def test_intervals_hold_the_truth() -> None:
    fit, whole = path(parameterise(THIRDS, ("stiffness",)), SOME)
    found = drawn(fit, whole, 600)
    assert found.draws.shape == (len(found.log_density), 3)
    for (low, high), value in zip(found.intervals, (1.0, 1.3, 1.0), strict=True):
        assert low < value < high  # each with 95 %: of this seed's noise all three


def test_draws_stay_within_bounds() -> None:
    fit, whole = path(parameterise(THIRDS, ("stiffness",), lower=0.999, upper=1.29), SOME)
    found = drawn(fit, whole, 300)
    assert found.draws.min() >= 0.999
    assert found.draws.max() <= 1.29
    assert found.draws.std(axis=0).min() > 0


def test_what_a_sparse_prior_left_out_has_no_draws() -> None:
    parameters = parameterise(THIRDS)
    fit, whole = path(parameters, SOME, Prior.SPARSE)
    found = drawn(fit, whole, 400)
    kept = [macro for macro, free in zip(parameters.macros, whole.posterior.is_active, strict=True) if free]
    assert list(found.macros) == kept
    assert 1 <= len(kept) < 6


def test_the_same_seed_draws_the_same() -> None:
    fit, whole = path(parameterise(THIRDS[1:2]), SOME)
    one, again, other = (drawn(fit, whole, 200, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.draws, again.draws)
    assert not np.array_equal(one.draws, other.draws)


def test_an_update_brings_its_draws_along() -> None:
    target = modes_of(TRUTH, 5, DOFS, SOME, seed=4)
    heard: list[float] = []

    def hear(*said: float | str) -> None:
        heard.append(float(said[0]))

    result = UPDATERS["one_shot"](
        MODEL,
        parameterise(THIRDS, ("stiffness",)),
        target,
        options=OneStageOptions(samples=300, seed=2, prior=Prior.RANGE),
        progress=hear,
    )
    assert result.posterior is not None
    assert len(result.posterior.draws) >= 300
    assert heard == sorted(heard)
    assert heard[-1] == pytest.approx(1.0)
    assert UPDATERS["one_shot"](MODEL, parameterise(THIRDS), target).posterior is None


def test_without_the_extra_it_is_said_which(monkeypatch: pytest.MonkeyPatch) -> None:
    fit, whole = path(parameterise(THIRDS[1:2]), SOME)
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(MissingExtraError, match="extra `mcmc`") as caught:
        drawn(fit, whole)
    assert "pip install modallab[mcmc]" in str(caught.value.context["allowed"])


def test_a_prior_that_leaves_nothing_free_has_nothing_to_draw() -> None:
    parameters = parameterise(THIRDS[1:2])
    target = real_modes(modes_of(MODEL, 5, DOFS, seed=4))
    fit = ModalResiduals(Assembly(MODEL), parameters, target, 0.0)
    whole = correct(fit, OneStageRule(Prior.SPARSE, 1e-8, 30, 1e3))
    nothing = replace(whole, posterior=replace(whole.posterior, prior_variances=np.zeros(2)))
    with pytest.raises(UnderdeterminedError, match="nothing to sample"):
        drawn(fit, nothing)

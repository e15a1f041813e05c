"""Fits restarted from other tolerances."""

from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.searching.restarted_fits import with_best_from_base
from modallab.effects.extra_mass import ExtraMass
from tests.diagnosing import draw_measurement, predicting, rig


@pytest.mark.parametrize("near", [False, True])
def test_far_from_the_data_the_best_effect_is_fitted_from_the_tolerances_before_it(*, near: bool) -> None:
    """Beside a model of a student's errors its fit from elsewhere ended in a gap of 8.7, this one in 1.0."""
    hidden = ExtraMass(Dof(6, "Y"), 0.1)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    nuisances = nuisance_parameters(Tolerances(modulus=0.01), predictor.system, predictor.setup)
    predictor = predictor.with_nuisances(nuisances)
    base = fit(predictor, ())
    assert not base.is_near_data
    best, other = (fit(predictor, (ExtraMass(Dof(node, "Y"), 0.1),)) for node in (6, 4))
    if not near:
        best = replace(best, chi_square=100.0 * base.n_data)  # as if it had ended in another minimum
    assert best.is_near_data == near
    assert other.chi_square > best.chi_square
    found, same = with_best_from_base(predictor, base, [best, other])
    assert found.is_near_data
    assert (found is best) == near
    assert same is other

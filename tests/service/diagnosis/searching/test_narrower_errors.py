from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import Fit, chi_square_with_own_errors, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching import narrower_errors
from modallab.diagnosis.searching.narrower_errors import with_narrower_errors
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

CUBIC, MASS = CubicStiffness(Dof(4, "Y"), 3e9), ExtraMass(Dof(2, "Y"), 0.01)


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    return predicting(draw_measurement(rig(noise=1e-5), [MASS, CUBIC]))[0]


def ended_at(predictor: Predictor, factor: float) -> Fit:
    """Return a fit as if it had ended at another stiffness, with its random errors."""
    effects = (MASS, replace(CUBIC, stiffness=factor * CUBIC.stiffness))
    chi_square = chi_square_with_own_errors(predictor, effects)
    return replace(
        fit(predictor, (MASS,)),
        effects=effects,
        residual=predictor.residual(effects),
        chi_square=chi_square,
    )


def test_a_fit_whose_errors_forgive_too_much_is_repeated_from_a_smaller_effect(
    predictor: Predictor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(narrower_errors, "parts_with_wide_errors", lambda *_: {"response"})
    forgiving = ended_at(predictor, 40.0)
    found = with_narrower_errors(predictor, forgiving, fit(predictor, ()))
    assert found.chi_square < forgiving.chi_square
    # Distortion of four simulated tests is known to a quarter, and its power follows the square.
    assert found.effects[1].parameters["stiffness"] == pytest.approx(CUBIC.stiffness, rel=0.25)
    assert found.effects[0].parameters["mass"] == pytest.approx(MASS.mass, rel=0.01)


def test_a_size_stays_where_the_likeliest_one_with_its_errors_is_less_likely_with_its_own(
    predictor: Predictor, monkeypatch: pytest.MonkeyPatch
) -> None:
    likeliest = 1.25 * CUBIC.stiffness  # five steps from the start

    def chi_square(_predictor: Predictor, effects: Sequence[Effect]) -> float:
        return abs(float(np.log(effects[1].parameters["stiffness"] / likeliest)))

    forgiving = ended_at(predictor, 40.0)
    monkeypatch.setattr(narrower_errors, "parts_with_wide_errors", lambda *_: {"response"})
    monkeypatch.setattr(narrower_errors, "chi_square_with_own_errors", chi_square)
    found = with_narrower_errors(predictor, forgiving, fit(predictor, ()))
    assert found.effects[1].parameters["stiffness"] == pytest.approx(likeliest, rel=1e-9)  # rounding
    assert found.effects[0].parameters["mass"] == pytest.approx(MASS.mass, rel=0.01)  # noise of the test


def test_a_fit_with_the_errors_of_its_data_stays(predictor: Predictor) -> None:
    found = fit(predictor, (MASS, CUBIC))
    assert with_narrower_errors(predictor, found, fit(predictor, ())) is found


def test_errors_of_the_right_size_are_the_likeliest(predictor: Predictor) -> None:
    right, too_small, too_large = (
        chi_square_with_own_errors(predictor, (MASS, replace(CUBIC, stiffness=factor * CUBIC.stiffness)))
        for factor in (1.0, 0.25, 4.0)
    )
    assert right < min(too_small, too_large)

import numpy as np

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.fitting import approach, fit
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.effects.stiffness_error import StiffnessError
from tests.diagnosing import drawn, predicting, rig


def test_stated_errors_are_the_scatter_of_the_fitted_numbers() -> None:
    true = StiffnessError(at=Members((3,)), factor=1.2)
    scores = []
    for seed in range(60):
        predictor, _ = predicting(drawn(rig(), [true], seed=seed))
        found = fit(predictor, [true])
        scores.append((found.effects[0].parameters["factor"] - 1.2) / found.errors[0]["factor"])
    # 60 draws: the standard deviation of a unit normal is known to 9 %, its mean to 0.13.
    assert 0.75 < np.std(scores) < 1.25
    assert abs(np.mean(scores)) < 0.4


def test_a_start_far_away_is_brought_home_on_blurred_residuals() -> None:
    true = StiffnessError(at=Members((3,)), factor=1.6)
    predictor, _ = predicting(drawn(rig(), [true]))
    near, _ = approach(predictor.near(()), (), true.with_parameters({"factor": 0.9}), widening=0.3)
    # On every line, periodic: the first look is exact, so only the random error (1e-4) is left.
    assert abs(near.parameters["factor"] - 1.6) < 2e-3


def test_two_effects_are_fitted_together() -> None:
    true = [StiffnessError(at=Members((3,)), factor=1.2), AccelerometerMass(mass=0.005)]
    predictor, _ = predicting(drawn(rig(), true))
    found = fit(
        predictor, [true[0].with_parameters({"factor": 1.1}), true[1].with_parameters({"mass": 0.01})]
    )
    for effect, errors, name, value in zip(
        found.effects, found.errors, ("factor", "mass"), (1.2, 0.005), strict=True
    ):
        assert abs(effect.parameters[name] - value) < 4 * errors[name]  # four standard errors
    assert found.n_parameters == 2


def test_a_parameter_stays_within_its_bounds() -> None:
    predictor, _ = predicting(drawn(rig()))
    found = fit(predictor, [AccelerometerMass(mass=0.4)])
    # Nothing is missing: driven towards zero, which lies infinitely far on the fit's logarithmic scale.
    assert 0 <= found.effects[0].parameters["mass"] < 2e-3


def test_a_number_far_below_its_upper_bound_is_fitted() -> None:
    true = JointFlexibility(at=Dof(4, "RZ"), flexibility=2e-5)
    assert true.flexibility < 1e-9 * true.specs()["flexibility"].upper
    predictor, _ = predicting(drawn(rig(), [true]))
    found = fit(predictor, [true.with_parameters({"flexibility": 3e-5})])
    error = found.errors[0]["flexibility"]
    assert abs(found.effects[0].parameters["flexibility"] - 2e-5) < 4 * error  # four standard errors

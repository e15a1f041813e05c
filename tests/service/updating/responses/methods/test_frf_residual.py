"""Coefficients found on frequency responses, without modes between."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import UnderdeterminedError, UnknownDofError
from modallab.core.frf import FrfKind
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import StructuralDamping
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.noise_bias import without_noise_bias
from modallab.rig.setup import RigSetup
from modallab.updating.method import UpdateResult
from modallab.updating.options import ResponseUpdateOptions, Underdetermined
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.responses import run
from modallab.updating.responses.methods.frf_residual import frf_residual
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.responses.target import TargetResponses, target_responses
from tests.service.updating.responses.cases import (
    AVERAGES,
    BAY,
    BAY_EACH,
    BAY_LINES,
    BAY_SENSORS,
    BEAM,
    BEAM_EACH,
    BEAM_LINES,
    BEAM_SENSORS,
    DRIVE,
    exact,
    measured,
    noisy,
)

WRONG = {
    ("mass", 7): 2.6,
    ("stiffness", 7): 0.4,
    ("stiffness", 12): 0.35,
    ("mass", 31): 0.5,
    ("stiffness", 24): 2.8,
}
KINDS = {"mass": MemberProperty.DENSITY, "stiffness": MemberProperty.MODULUS}
TRUE_BAY = change(BAY, [MemberChange((n,), KINDS[part], factor=f) for (part, n), f in WRONG.items()])
BEAM_WRONG = {("mass", 4): 1.7, ("stiffness", 11): 0.45, ("stiffness", 12): 0.6}
TRUE_BEAM = change(BEAM, [MemberChange((n,), KINDS[part], factor=f) for (part, n), f in BEAM_WRONG.items()])


def worst(result: UpdateResult, wrong: dict[tuple[str, int], float]) -> float:
    """Return the largest error of a coefficient; no change of damping is 0."""
    tables = result.coefficients.items()
    return max(
        abs(value - wrong.get((part, number), 0.0 if part == "damping" else 1.0))
        for part, table in tables
        for number, value in table.items()
    )


@cache
def on_bay() -> UpdateResult:
    return frf_residual(BAY, BAY_EACH, exact(measured(TRUE_BAY, BAY_LINES, BAY_SENSORS)))


def test_far_wrong_elements_are_found_among_all_of_a_bay() -> None:
    result = on_bay()
    assert result.converged, result.stopped_because
    # the last step moves nothing by 1e-4, and steps shrink by their squares
    assert worst(result, WRONG) < 1e-6
    assert result.suspected == {"mass": (7, 31), "stiffness": (7, 12, 24)}
    assert result.iterations == {"location": 0, "updating": len(result.history)}


def test_the_corrected_structure_has_the_true_frequencies() -> None:
    result = on_bay()
    known = assemble(TRUE_BAY).modes().elastic(10).frequencies
    np.testing.assert_allclose(result.frequencies.after[:10], known, rtol=1e-6)
    assert result.frequencies.measured is None


def test_what_was_missed_before_and_after_is_told() -> None:
    fit = on_bay().responses
    assert fit is not None
    assert fit.before > 1e6 > 1 > fit.after
    assert fit.by_frf_before.shape == (30, 1)
    assert fit.n_held_out == 0
    assert fit.held_out_after is None
    assert fit.scatter == pytest.approx(np.sqrt(2 / (2 * 40 * 30)))


def test_elements_of_a_beam_are_found_from_inertance_too() -> None:
    frf = measured(TRUE_BEAM, BEAM_LINES, BEAM_SENSORS).to(FrfKind.INERTANCE)
    target = target_responses(frf, np.ones(frf.values.shape[:2]), AVERAGES)
    assert worst(frf_residual(BEAM, BEAM_EACH, target), BEAM_WRONG) < 1e-6


def test_losses_are_found_beside_mass_and_stiffness() -> None:
    lossy = change(TRUE_BEAM, [MemberChange((5,), MemberProperty.LOSS_FACTOR, value=0.105)])
    parameters = parameterise([(n,) for n in range(1, 21)], ("mass", "stiffness", "damping"))
    result = frf_residual(BEAM, parameters, exact(measured(lossy, BEAM_LINES, BEAM_SENSORS)))
    # the beam loses 0.005 throughout by itself
    assert worst(result, BEAM_WRONG | {("damping", 5): 0.1}) < 1e-6


def test_an_undamped_model_takes_its_losses_from_the_responses() -> None:
    bare = replace(STRUCTURES["chapter-5-beam"](), damping=StructuralDamping())
    lossy = replace(TRUE_BEAM, damping=StructuralDamping(0.02))
    whole = parameterise([tuple(range(1, 21))], ("damping",))
    macros = (*BEAM_EACH.macros, *whole.macros)
    target = exact(measured(lossy, BEAM_LINES, BEAM_SENSORS))
    result = frf_residual(bare, Parameterisation(macros), target)
    known = BEAM_WRONG | {("damping", n): 0.02 for n in range(1, 21)}
    assert worst(result, known) < 1e-6


def test_intervals_hold_the_truth_with_ninety_five_per_cent() -> None:
    frf = measured(TRUE_BAY, BAY_LINES, BAY_SENSORS)
    inside, left, errors = [], [], []
    for seed in range(4):
        result = frf_residual(BAY, BAY_EACH, noisy(frf, 0.98, seed))
        assert result.responses is not None
        left.append(result.responses.after)
        errors.append(worst(result, WRONG))
        inside += [
            low <= WRONG.get((part, number), 1.0) <= high
            for part, table in result.intervals.items()
            for number, (low, high) in table.items()
        ]
    # 248 intervals, correlated within a draw; the acceptance itself is 90 to 99 %
    assert 0.90 <= np.mean(inside) <= 0.99
    # 2400 numbers less some 10 that fitting used: 1 +- 0.03, five of them
    assert np.abs(np.array(left) - 1).max() < 0.15
    assert max(errors) < 0.1


def test_noise_that_all_responses_share_counts_once() -> None:
    """A tenth of the force's size: all of H1 is a hundredth too small, and moves together by chance."""
    whole = parameterise([tuple(range(1, 21))], ("mass", "stiffness"))
    analyser = Analyser(1600.0, 33, averages=int(AVERAGES))
    setup = RigSetup(DRIVE, BEAM_SENSORS, noise=Noise(force=0.01, response=1e-4), analyser=analyser)
    inside = []
    for seed in range(24):
        test = measure(BEAM, setup, route=Route.DRAWN, rng=np.random.default_rng(seed))
        frf, common = without_noise_bias(test)
        result = frf_residual(
            BEAM, whole, target_responses(frf, test.coherence, test.averages, common=common)
        )
        inside += [table[1][0] <= 1 <= table[1][1] for table in result.intervals.values()]
    # mass and stiffness are off together, so that these are 24 draws: 95 % less two errors of 4.4 %
    assert np.mean(inside) > 0.86


def test_lines_beyond_those_that_are_used_are_held_out(monkeypatch: pytest.MonkeyPatch) -> None:
    max_numbers = 2 * 40 * len(BEAM_SENSORS)
    monkeypatch.setattr(run, "RESPONSE_PATH", replace(RESPONSE_PATH, max_numbers=max_numbers))
    target = noisy(measured(TRUE_BEAM, BEAM_LINES, BEAM_SENSORS), 0.98, 2)
    fit = frf_residual(BEAM, BEAM_EACH, target).responses
    assert fit is not None
    assert (len(fit.freq), fit.n_held_out) == (40, 120)
    assert fit.held_out_before is not None
    assert fit.held_out_after is not None
    assert fit.held_out_before > 100
    # 2640 numbers: 1 +- 0.03, and what the errors of coefficients add
    assert abs(fit.held_out_after - 1) < 0.2


def test_what_no_coefficient_explains_is_told() -> None:
    heavier = change(BEAM, [MemberChange((4,), MemberProperty.DENSITY, factor=3.0)])
    only = parameterise([(15, 16)], ("stiffness",))
    result = frf_residual(BEAM, only, noisy(measured(heavier, BEAM_LINES[::8], BEAM_SENSORS), 0.98, 1))
    assert "times their random errors" in result.stopped_because


def few() -> TargetResponses:
    target = exact(measured(TRUE_BEAM, BEAM_LINES, BEAM_SENSORS[:1]))
    return target.at(np.arange(10))


def test_too_few_numbers_are_refused_with_their_count() -> None:
    with pytest.raises(UnderdeterminedError, match="20 measured numbers cannot determine 40"):
        frf_residual(BEAM, BEAM_EACH, few())


def test_too_few_numbers_are_left_to_the_prior_where_asked() -> None:
    result = frf_residual(
        BEAM, BEAM_EACH, few(), options=ResponseUpdateOptions(underdetermined=Underdetermined.REGULARISED)
    )
    assert result.rank <= 20
    assert result.identifiability is not None
    assert result.identifiability.directions


def test_sensors_that_the_model_lacks_are_refused() -> None:
    target = replace(few(), outputs=(Dof(77, "Y"),))
    with pytest.raises(UnknownDofError, match="77"):
        frf_residual(BEAM, BEAM_EACH, target)


def test_coefficients_that_move_nothing_are_refused() -> None:
    axial = parameterise([(1,), (2,)], ("axial",))
    with pytest.raises(UnderdeterminedError, match="no measured number moves"):
        frf_residual(BEAM, axial, few())

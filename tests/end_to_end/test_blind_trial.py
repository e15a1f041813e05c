"""A few sealed cases, as the whole trial in `benchmarks.blind_trial` runs them."""

import pickle
from dataclasses import replace

import pytest

from benchmarks.blind_trial import Case, beam, cases, run_case, sealed
from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.response_noise import ResponseNoise

SEED = 7
KINDS = (
    "accelerometer_mass",
    "density_error",
    "exciter_armature",
    "extra_mass",
    "force_noise",
    "force_transducer_mass",
    "leakage",
    "response_noise",
    "stiffness_error",
)
CASES = cases(len(KINDS) + 1, SEED, nothing=1, kinds=KINDS)


def periodic(case: Case) -> bool:
    """Return whether the case is quick: leaking data cost a minute and are left to the whole trial."""
    return case.setup.analyser.excitation.kind == "periodic_random"


@pytest.mark.parametrize("case", [c for c in CASES if periodic(c)], ids=lambda case: str(case.number))
def test_a_sealed_case_is_solved(case: Case) -> None:
    score = run_case(case)
    assert score.right, f"{case.truth} was called {score.named}"
    assert not score.false_alarm
    assert case.truth is None or score.held_out_closed


def test_a_measurement_holds_nothing_of_the_truth() -> None:
    """Two truths that leave the same data leave the same measurement: no word of either is in it."""
    measurement = sealed(next(c for c in CASES if c.truth is not None))
    seen = pickle.dumps(measurement.setup) + repr(measurement.notes).encode()
    for name in ("extra_mass", "stiffness_error", "density_error", "response_noise", "exciter_armature"):
        assert name.encode() not in seen
    assert measurement.setup.effects == ()


def test_the_diagnosis_is_made_of_the_measurement_alone() -> None:
    """With the truth swapped for another after the test, the diagnosis is byte for byte the same."""
    case = replace(CASES[0], truth=ExtraMass(at=Dof(5, "Y"), mass=0.02))
    measurement = sealed(case)
    kept = pickle.dumps(measurement)
    first = diagnose(beam(), measurement, suspects=["extra_mass", "response_noise"])
    case = replace(case, truth=ResponseNoise(ratio=1e-2))
    again = diagnose(beam(), pickle.loads(kept), suspects=["extra_mass", "response_noise"])
    assert pickle.dumps(first.steps) == pickle.dumps(again.steps)
    assert first.curves.after.tobytes() == again.curves.after.tobytes()

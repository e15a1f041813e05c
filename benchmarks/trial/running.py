"""Runs one sealed case: measure, diagnose with nothing but the measurement, score."""

import pickle
import time
import traceback
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.trial.cases import Case
from benchmarks.trial.scoring import score
from benchmarks.trial.tolerated import tolerances
from modallab.core.errors import ModalLabError
from modallab.diagnosis import diagnose as door
from modallab.diagnosis.predicting.joint import FollowUp
from modallab.diagnosis.result import Diagnosis
from modallab.fe.structure import Structure
from modallab.rig.carried_over import carried_over
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

MOST_TESTS = 2  # proposed next tests that are run where a set asks for it


def sealed(case: Case) -> Measurement:
    """Return the measurement of a case: arrays, and the rig as its log book has it."""
    return _measured(case, case.setup, case.bench.setup, case.acting, case.seed)


def _measured(
    case: Case, actual: RigSetup, declared: RigSetup, acting: Sequence[Effect], seed: int
) -> Measurement:
    rng = np.random.default_rng(seed)
    found = measure(case.bench.structure, actual, acting, route=Route.SAMPLED, rng=rng)
    frf = replace(found.frf, inputs=declared.drives)
    return replace(found, frf=frf, setup=declared)


def run(case: Case) -> dict[str, Any]:
    """Return the score of a case, as plain data."""
    kept = pickle.dumps(sealed(case))  # with the model all that the diagnosis is given
    start = time.process_time()
    found: Diagnosis | None = None
    trouble = ""
    tests: list[dict[str, Any]] = []
    structure, measurement = case.bench.structure, pickle.loads(kept)
    try:
        found = _diagnosed(case, structure, measurement)
        first_answer = time.process_time() - start
        if case.set == "3a":
            found = _followed_up(case, structure, measurement, found, tests)
    except Exception:  # whatever it is, the trial goes on and counts it as wrong
        trouble, first_answer = traceback.format_exc(limit=-6), time.process_time() - start
    seconds = time.process_time() - start
    return score(case, measurement, found) | {
        "seconds": first_answer,
        "seconds_with_tests": seconds,
        "trouble": trouble,
        "tests": tests,
    }


def _diagnosed(case: Case, structure: Structure, measurement: Measurement, **more: Any) -> Diagnosis:
    if case.tolerances:
        more["tolerances"] = tolerances(case.bench)
    return door.diagnose(structure, measurement, suspects=case.suspects, **more)


def _followed_up(
    case: Case, structure: Structure, measurement: Measurement, found: Diagnosis, tests: list[dict[str, Any]]
) -> Diagnosis:
    """Return the diagnosis after the tests it asked for, each made on the sealed truth."""
    further: list[FollowUp] = []
    while found.next_test is not None and len(further) < MOST_TESTS:
        plain = dict(found.next_test.change)
        tests.append({"change": plain, "why": found.next_test.why})
        try:
            change = Change.read(plain)
            declared, actual = change.applied(case.bench.setup), change.applied(case.setup)
        except ModalLabError as error:
            tests[-1]["refused"] = str(error)
            break
        acting = carried_over(case.acting, case.setup, actual)
        seed = case.seed + 1 + len(further)
        further.append(FollowUp(_measured(case, actual, declared, acting, seed), change))
        found = _diagnosed(case, structure, measurement, follow_ups=tuple(further))
    return found

"""Runs one sealed case: measure, diagnose with nothing but the measurement, score."""

import pickle
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.trial.cases import Case
from benchmarks.trial.scoring import score
from benchmarks.trial.tolerated import tolerances
from modallab.core.errors import ModalLabError
from modallab.diagnosis import diagnose as door
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, Tolerances
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.result import Diagnosis
from modallab.fe.structure import Structure
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.effects_in_other_test import effects_in_other_test
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
    measurement = measure(case.bench.structure, actual, acting, route=Route.SAMPLED, rng=rng)
    frf = replace(measurement.frf, inputs=declared.drives)
    return replace(measurement, frf=frf, setup=declared)


@dataclass(frozen=True)
class Question:
    """All that a diagnosis is given of a case: nothing of its truth."""

    structure: Structure
    measurement: Measurement  # and the log book with it
    suspects: list[str] | None  # kinds; None for all
    tolerances: Tolerances
    follow_ups: tuple[FollowUp, ...] = ()

    @classmethod
    def of(cls, case: Case) -> "Question":
        """Return what is asked of a case once it has been measured."""
        sealed_case = pickle.dumps(sealed(case))
        tolerated = tolerances(case.bench) if case.tolerances else NO_TOLERANCES
        return cls(case.bench.structure, pickle.loads(sealed_case), case.suspects, tolerated)


@dataclass(frozen=True)
class Answer:
    """A diagnosis, or the trouble that there is none."""

    diagnosis: Diagnosis | None
    seconds: float
    trouble: str = ""


Ask = Callable[[Question], Answer]


def answered_here(question: Question) -> Answer:
    """Return the answer of a diagnosis in this process, and the CPU time that it took."""
    start = time.process_time()
    diagnosis, trouble = None, ""
    try:
        diagnosis = door.diagnose(
            question.structure,
            question.measurement,
            suspects=question.suspects,
            tolerances=question.tolerances,
            follow_ups=question.follow_ups,
        )
    except Exception:  # whatever it is, the trial goes on and counts it as wrong
        trouble = traceback.format_exc(limit=-6)
    return Answer(diagnosis, time.process_time() - start, trouble)


def run(case: Case, ask: Ask = answered_here) -> dict[str, Any]:
    """Return the score of a case, as plain data; of set 3a that before any further test beside it.

    Parameters
    ----------
    ask
        Who answers: without knowing more of the case than the question.
    """
    question = Question.of(case)
    first = ask(question)
    scored = _scored(replace(case, set="3") if case.set == "3a" else case, question, first, first)
    if case.set != "3a":
        return scored
    last, tests = first, list[dict[str, Any]]()
    try:
        last = _followed_up(case, question, first, tests, ask)
    except Exception:
        last = replace(first, trouble=traceback.format_exc(limit=-6))
    return _scored(case, question, first, last, tests) | {"first": scored}


def _scored(
    case: Case, question: Question, first: Answer, last: Answer, tests: Sequence[dict[str, Any]] = ()
) -> dict[str, Any]:
    return score(case, question.measurement, last.diagnosis) | {
        "seconds": first.seconds,
        "seconds_with_tests": last.seconds,
        "trouble": last.trouble,
        "tests": list(tests),
    }


def _followed_up(
    case: Case, question: Question, first: Answer, tests: list[dict[str, Any]], ask: Ask
) -> Answer:
    """Return the answer after the tests it asked for, each made on the sealed truth; its seconds are of all.

    Where there is no answer after a test, that before it stays, with the trouble.
    """
    last, follow_ups = first, list[FollowUp]()
    while (
        last.diagnosis is not None and last.diagnosis.next_test is not None and len(follow_ups) < MOST_TESTS
    ):
        plain = dict(last.diagnosis.next_test.change)
        tests.append({"change": plain, "why": last.diagnosis.next_test.why})
        try:
            change = Change.read(plain)
            declared, actual = change.applied(case.bench.setup), change.applied(case.setup)
        except ModalLabError as error:
            tests[-1]["refused"] = str(error)
            break
        acting = effects_in_other_test(case.acting, case.setup, actual)
        seed = case.seed + 1 + len(follow_ups)
        follow_ups.append(FollowUp(_measured(case, actual, declared, acting, seed), change))
        again = ask(replace(question, follow_ups=tuple(follow_ups)))
        last = Answer(again.diagnosis or last.diagnosis, last.seconds + again.seconds, again.trouble)
        if again.trouble:
            break
    return last

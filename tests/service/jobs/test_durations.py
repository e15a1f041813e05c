"""Durations of jobs: near what was measured, and refused before anybody waits for hours."""

import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import EffectSpec
from modallab.jobs.durations import Duration, duration_of_measurement, duration_of_solutions
from modallab.rig.analyser import Analyser
from modallab.rig.effect import Effect, build
from modallab.rig.hardware import Accelerometers
from modallab.rig.measure import Route
from modallab.rig.setup import RigSetup

CUBIC = build(EffectSpec("cubic_stiffness", Dof.parse("11:+Y"), {"stiffness": 1e9}))


def setup_of(n_responses: int, n_lines: int, averages: int, *, roving: bool = False) -> RigSetup:
    return RigSetup(
        drives=(Dof.parse("1:+Y"),),
        responses=tuple(Dof.parse(f"{n}:+Y") for n in range(1, n_responses + 1)),
        accelerometers=Accelerometers(roving=roving),
        analyser=Analyser(frequency_max=800.0, n_lines=n_lines, averages=averages),
    )


@pytest.mark.parametrize(
    ("setup", "effects", "measured"),
    [
        (setup_of(21, 1601, 1000), (), 2.1),
        (setup_of(5, 401, 4000), (CUBIC,), 35.0),
        (setup_of(5, 1601, 200), (CUBIC,), 3.1),
    ],
)
def test_a_duration_is_near_what_was_measured(
    setup: RigSetup, effects: tuple[Effect, ...], measured: float
) -> None:
    seconds = duration_of_measurement(setup, effects, Route.SAMPLED).seconds
    assert measured / 3 < seconds < 6 * measured  # another machine, and rounded up


def test_only_records_take_long() -> None:
    setup = setup_of(21, 1601, 100_000)
    assert duration_of_measurement(setup, (CUBIC,), Route.EXPECTED).seconds == 0
    assert duration_of_measurement(setup, (), Route.DRAWN).seconds == 0


def test_what_roves_takes_one_run_a_position() -> None:
    fixed, roving = (
        duration_of_measurement(setup_of(20, 401, 10, roving=r), (CUBIC,), Route.SAMPLED).seconds
        for r in (False, True)
    )
    assert 10 < roving / fixed < 20  # 20 runs; those of a fixed rig have more channels


def test_a_refusal_names_field_estimate_and_limit() -> None:
    Duration(9.0, "averages", 100).check(9.0)
    with pytest.raises(InvalidInputError, match="18 s") as refused:
        Duration(18.0, "averages", 100).check(9.0)
    context = refused.value.context
    assert context == {
        "field": "averages",
        "value": 100,
        "allowed": {"maximum": 50},
        "estimate": 18.0,
        "limit": 9.0,
    }
    with pytest.raises(InvalidInputError) as hopeless:
        Duration(1800.0, "averages", 1).check(9.0)
    assert hopeless.value.context["allowed"] == "a smaller test or model"


@pytest.mark.parametrize(("n_dofs", "measured"), [(42, 0.002), (1260, 0.04), (10_980, 0.6), (120_600, 14.0)])
def test_solutions_take_what_was_measured(n_dofs: int, measured: float) -> None:
    assert measured / 3 < duration_of_solutions(n_dofs, 1, "count", 1).seconds < 3 * measured

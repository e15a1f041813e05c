"""A few quick sealed cases as the whole trial in `benchmarks.blind_trial` runs them, and its scorer."""

import copy
import json
import pickle
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from benchmarks.blind_trial import case_numbers, main, read
from benchmarks.trial.cases import KINDS, LATER_KINDS, NOISES, PAIRED, ROUND, case, small_case
from benchmarks.trial.hidden import Gauge, measurable
from benchmarks.trial.reporting import calibration_error, report
from benchmarks.trial.rigs import cantilever, frame, free_beam, short_beam, small_bench
from benchmarks.trial.running import run, sealed
from benchmarks.trial.scoring import score
from benchmarks.trial.through_service import answered_by, model_body
from benchmarks.trial.tolerated import Tolerated
from modallab.api.rigs.replies import rig_request
from modallab.api.rigs.schemas import RigIn
from modallab.api.structures.schemas import StructureIn
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import FittedEffect, FittedParameter
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.response_noise import ResponseNoise
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS
from modallab.store.plain import to_plain
from modallab_client import ModalLab
from modallab_client.errors import NotFoundError

SEED = 7
FEW = ("extra_mass", "exciter_armature", "polarity", "gain_error", "response_noise")


@cache
def scored(kind: str | None) -> dict[str, Any]:
    """Return the score of a quick case."""
    return run(small_case(kind, SEED, FEW))


@pytest.mark.parametrize("kind", ["extra_mass", "polarity", "response_noise", None])
def test_a_sealed_case_is_solved(kind: str | None) -> None:
    line = scored(kind)
    assert line["right"], f"{line['truth']} was called {line['steps']}"
    assert line["within_scatter"]
    if line["steps"] and line["held_out_before"] > line["held_out_noise"]:
        assert line["held_out_after"] < 0.01 * line["held_out_before"]


def test_a_measurement_holds_nothing_of_the_truth() -> None:
    """No word of what was hidden is in it, and its log book is the declared one to the last number."""
    true = small_case("extra_mass", SEED, FEW)
    measurement = sealed(true)
    assert b"extra_mass" not in pickle.dumps(measurement)
    assert measurement.setup == true.bench.setup
    assert measurement.setup.effects == ()


def test_a_service_answers_as_the_diagnosis_itself_does() -> None:
    """The same score to the last digit: no number is rounded on its way there or back."""
    apart = ("seconds", "seconds_with_tests", "candidates")  # of which no reply tells
    with ModalLab.embedded() as lab:
        for kind in ("polarity", "extra_mass"):
            line = run(small_case(kind, SEED, FEW), partial(answered_by, lab.base_url))
            assert line["trouble"] == ""
            assert line["steps"]
            assert 0 < line["seconds"] < 60
            told, here = ({k: v for k, v in one.items() if k not in apart} for one in (line, scored(kind)))
            assert json.dumps(told) == json.dumps(here)
        for test in lab.measurements.list():
            with pytest.raises(NotFoundError):  # the service has only been shown what was measured
                lab.measurements.truth(test.id)


@pytest.mark.parametrize("structure", [free_beam(), cantilever(), frame(), short_beam()])
def test_a_model_of_the_trial_is_said_over_http_to_the_last_digit(structure: Structure) -> None:
    wire: TypeAdapter[Any] = TypeAdapter(StructureIn)
    read_back = wire.validate_json(json.dumps(model_body(structure))).to_domain()
    assert to_plain(read_back) == to_plain(structure)


@pytest.mark.parametrize("kind", ["friction", "transverse_sensitivity", "double_hit", "polarity"])
def test_a_log_book_of_the_trial_is_said_over_http_to_the_last_digit(kind: str) -> None:
    setup = case(KINDS.index(kind), SEED, "2" if kind == "polarity" else "1").bench.setup
    assert RigIn.model_validate_json(json.dumps(rig_request(setup))).to_domain() == setup


def test_what_a_service_does_not_run_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["blind_trial", "--set", "3a", "--service", "http://nowhere"])
    with pytest.raises(SystemExit):
        main()
    assert "3a measures further tests on the sealed truth" in capsys.readouterr().err


def test_a_wrong_log_book_is_what_the_measurement_carries() -> None:
    """Measured by the rig as it was, handed over with the rig as it was declared."""
    true = small_case(None, SEED, FEW)
    heavier = replace(true.setup, accelerometers=replace(true.setup.accelerometers, mass=0.05))
    told = sealed(replace(true, setup=heavier))
    assert told.setup == true.bench.setup
    assert not np.allclose(told.frf.values, sealed(true).frf.values)


def test_the_diagnosis_is_made_of_the_measurement_alone() -> None:
    """With the truth swapped for another after the test, the diagnosis is byte for byte the same."""
    true = small_case(None, SEED, FEW)
    true = replace(true, truth=(ExtraMass(at=Dof(5, "Y"), mass=0.02),), type="single")
    measurement = sealed(true)
    kept = pickle.dumps(measurement)
    first = diagnose(true.bench.structure, measurement, suspects=["extra_mass", "response_noise"])
    true = replace(true, truth=(ResponseNoise(ratio=1e-2),))
    again = diagnose(true.bench.structure, pickle.loads(kept), suspects=["extra_mass", "response_noise"])
    assert pickle.dumps(first.steps) == pickle.dumps(again.steps)
    assert first.curves.after.tobytes() == again.curves.after.tobytes()


@pytest.mark.parametrize("number", [KINDS.index("density_error"), 45, 50])
def test_a_case_is_the_same_whatever_else_is_drawn(number: int) -> None:
    first = case(number, SEED)
    case(number + 1, SEED)
    again = case(number, SEED)
    assert (first.truth, first.seed, first.setup, first.gap) == (
        again.truth,
        again.seed,
        again.setup,
        again.gap,
    )
    assert case(number, SEED + 1).seed != first.seed


def test_kinds_that_came_later_have_a_set_of_their_own_and_change_no_other() -> None:
    drawn = [case(number, SEED, "4") for number in range(6)]
    assert tuple(one.truth[0].kind for one in drawn) == LATER_KINDS * 2
    assert all(one.type == "single" and one.gap >= 0.95 * 2 for one in drawn)
    assert drawn[0].bench.setup.noise != drawn[3].bench.setup.noise
    assert set(LATER_KINDS).isdisjoint((*KINDS, *PAIRED)), "the order of the others decides their draws"


def test_a_round_has_every_kind_once_and_the_next_another_noise() -> None:
    drawn = [case(KINDS.index("polarity") + lap * ROUND, SEED) for lap in range(3)]
    assert [one.truth[0].kind for one in drawn] == ["polarity"] * 3
    assert {one.bench.setup.noise.response for one in drawn} == set(NOISES)


def test_an_effect_is_as_strong_as_the_gap_it_is_said_to_open() -> None:
    true = case(KINDS.index("density_error"), SEED)
    assert 2 <= true.gap <= 1e4
    assert Gauge(true.bench).opened(true.truth) == pytest.approx(true.gap, rel=1e-9)  # the same sums


def test_an_effect_is_no_stronger_than_can_be_measured() -> None:
    """This brake was ten times as hard before: expected spectra had it, steps in time did not."""
    true = case(KINDS.index("friction") + 2 * ROUND, 5001)
    (brake,) = true.truth
    assert true.gap >= 2
    assert measurable(brake, true.bench) is brake
    with pytest.raises(DivergedError):
        measurable(brake.with_parameters({"force": 10 * brake.parameters["force"]}), true.bench)


def test_what_is_hidden_is_more_than_all_that_is_tolerated_could_be_together() -> None:
    """1.5 % of density is within three times 0.3 % of modulus and three times 0.2 % of density together."""
    known = Tolerated(small_bench(np.random.default_rng(SEED), noise=1e-4))
    assert known.unexplained([DensityError(factor=1 + 2.5 * 0.002 + 2.5 * 0.003)]) < 1.3
    assert known.unexplained([DensityError(factor=1 + 4 * 0.002 + 4 * 0.003)]) > 2


def test_what_is_out_of_the_catalogue_is_not_suspected() -> None:
    """Foreign effects have no name at all; hidden ones are taken out of the list."""
    drawn = [case(len(KINDS) + 10 + i, SEED) for i in range(2)]
    for one in drawn:
        assert one.type == "unknown"
        kind = one.truth[0].kind
        assert kind not in (one.suspects if one.suspects is not None else EFFECTS)


def test_another_name_counts_only_where_predictions_agree() -> None:
    """A mass at the drive point is the gauge's mass exactly, and another node's is not."""
    true = replace(
        small_case(None, SEED, FEW), truth=(ForceTransducerMass(mass=0.01),), type="single", gap=np.nan
    )
    measurement = sealed(true)
    found = diagnose(true.bench.structure, measurement, suspects=["extra_mass"], max_effects=1)

    def answered(kind: str, at: Dof | None) -> dict[str, Any]:
        named = FittedEffect(kind, at, {"mass": FittedParameter(0.01, 1e-6, "kg")})
        return score(true, measurement, replace(found, steps=(replace(found.steps[0], effect=named),)))

    own, alias = answered("force_transducer_mass", None), answered("extra_mass", Dof(1, "Y"))
    wrong = answered("extra_mass", Dof(5, "Y"))
    assert (own["right"], own["by_alias"]) == (True, False)
    assert (alias["right"], alias["by_alias"]) == (True, True)
    assert (wrong["right"], wrong["by_alias"]) == (False, False)
    assert own["steps"][0]["errors"]["mass"] == pytest.approx([0, 0, 0])


def test_calibration_is_the_distance_of_belief_from_truth() -> None:
    """Nine of ten right when 0.9 was said is perfect, none of ten is off by all of it."""
    good = [(0.9, True)] * 9 + [(0.9, False)]
    assert calibration_error(good) == pytest.approx(0.0, abs=1e-12)
    assert calibration_error([(0.9, False)] * 10) == pytest.approx(0.9)


def test_the_page_says_what_was_called_what() -> None:
    lines = [copy.deepcopy(scored(kind)) for kind in ("polarity", None)]
    lines[0]["steps"][0]["kind"], lines[0]["right"] = "gain_error", False
    page = report(lines)
    assert "| `polarity` | 1 | 0 |  |  | gain_error 1 |" in page
    assert "| no missing effect, recognised | 1 | 1 | 100 %" in page


def test_numbers_are_read_with_their_ranges() -> None:
    assert case_numbers("3,7-9,40") == [3, 7, 8, 9, 40]


def test_a_trial_that_was_cut_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A whole line is not run again, half of one is; here of cases that nothing has to be fitted for."""
    out = tmp_path / "lines.jsonl"
    numbers_here = [len(KINDS) + 6, len(KINDS) + 7]  # nothing is missing in them
    known = {"set": "1", "seed": SEED, "number": numbers_here[0], "void": "run before"}
    out.write_text(json.dumps(known) + "\n" + '{"set": "1", "seed"')
    wanted = ["--only", ",".join(map(str, numbers_here)), "--seed", str(SEED), "--workers", "1"]
    monkeypatch.setattr("sys.argv", ["blind_trial", *wanted, "--resume", "--out", str(out)])
    main()
    lines = read([out])
    assert [line["number"] for line in lines] == numbers_here
    assert lines[0] == known
    assert lines[1]["verdict"] == "nothing_missing"
    page = tmp_path / "page.md"
    monkeypatch.setattr("sys.argv", ["blind_trial", "--out", str(out), "--report", str(page)])
    main()
    assert "| no missing effect, recognised | 1 | 1 | 100 %" in page.read_text()

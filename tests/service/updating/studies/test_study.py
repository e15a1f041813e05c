"""A method tried on noisy modes of a known structure."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import CancelledError, InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.error_location.run import locate
from modallab.updating.method import UPDATERS
from modallab.updating.options import LocationOptions, UpdateOptions
from modallab.updating.parameterisation import Part, parameterise
from modallab.updating.partitioning import automatic_groups
from modallab.updating.studies.plan import NOISE_LEVELS, Division, Level, StudyPlan
from modallab.updating.studies.run import run_once
from modallab.updating.studies.study import Study
from modallab.updating.studies.truth import true_coefficients
from tests.service.updating.cases import BEAM, BEAM_DOFS, WRONG_BEAM, modes_of

LEVELS = tuple(Level(name, noise) for name, noise in NOISE_LEVELS.items())
EACH = Division("each", parameterise([(n,) for n in range(1, 21)]))
RUNS = Division("runs", parameterise(automatic_groups(BEAM)))
PLAN = StudyPlan("one_shot", LEVELS[::2], (EACH, RUNS), (3, 4), 8, BEAM_DOFS, UpdateOptions())


def made(plan: StudyPlan, truth: Structure = WRONG_BEAM) -> Study:
    """Return a study of the beam, its runs one after the other."""
    true, system = true_coefficients(BEAM, truth, plan.parts), assemble(truth)
    runs, rows = zip(*(run_once(plan, i, BEAM, system, true) for i in range(plan.n_runs)), strict=True)
    table = np.array([row for row in rows if row is not None]).reshape(-1, sum(map(len, true.values())))
    return Study(plan, true, runs, table)


@pytest.fixture(scope="module")
def study() -> Study:
    return made(PLAN)


def test_runs_are_levels_of_divisions_of_seeds(study: Study) -> None:
    keys = [(run.level, run.division, run.seed) for run in study.runs]
    assert keys == [
        (level, division, seed)
        for level in ("NL1", "NL3")
        for division in ("each", "runs")
        for seed in (3, 4)
    ]
    assert [(cell.level, cell.division) for cell in study.cells] == list(
        dict.fromkeys((level, division) for level, division, _ in keys)
    )


def test_the_levels_are_those_of_the_thesis() -> None:
    sizes = {name: (noise.eigenvalue, noise.eigenvector) for name, noise in NOISE_LEVELS.items()}
    assert sizes == {"NL1": (0, 0), "NL2": (0.002, 0.02), "NL3": (0.005, 0.05), "NL4": (0.01, 0.1)}


def test_without_noise_every_wrong_element_is_found_and_no_other(study: Study) -> None:
    cell = study.cells[0]
    assert (cell.n_runs, cell.n_failed, cell.n_converged) == (2, 0, 2)
    assert (cell.suspected, cell.unfounded) == (1.0, 0.0)
    assert cell.coefficient_error is not None
    assert cell.frequency_error is not None
    # steps end below 1e-4 and converge quadratically
    assert max(cell.coefficient_error) < 1e-6
    assert max(cell.frequency_error) < 1e-6


def test_coarser_macro_elements_that_mix_right_and_wrong_members_miss_the_truth(study: Study) -> None:
    each, runs = study.cells[:2]
    assert each.coefficient_error is not None
    assert runs.coefficient_error is not None
    # members 1 to 4 share a coefficient: whatever it is, it is half of the doubling off in two of them
    assert runs.coefficient_error[0] > 0.4 > each.coefficient_error[1]


def test_a_run_is_the_update_of_modes_drawn_from_its_seed(study: Study) -> None:
    level, division, seed = PLAN.run(5)
    run, table = study.runs[5], study.coefficients[5]
    target = modes_of(WRONG_BEAM, 8, BEAM_DOFS, level.noise, seed)
    alone = UPDATERS["one_shot"](BEAM, division.parameterisation, target)
    found = [value for part in alone.coefficients.values() for value in part.values()]
    np.testing.assert_array_equal(table, found)
    truth = [value for part in study.true.values() for value in part.values()]
    assert run.coefficient_error == np.abs(np.array(found) - truth).max()
    exact = modes_of(WRONG_BEAM, 8, BEAM_DOFS).frequencies
    # two eigen-solutions of one model
    assert run.frequency_error == pytest.approx(np.abs(alone.frequencies.after / exact - 1).max(), rel=1e-6)
    assert run.suspected == alone.suspected
    inside = [
        low <= study.true[part][n] <= high
        for part, ends in alone.intervals.items()
        for n, (low, high) in ends.items()
    ]
    assert run.coverage == np.mean(inside)


def test_the_same_seeds_give_the_same_bytes(study: Study) -> None:
    again = made(PLAN)
    assert again.runs == study.runs
    assert again.coefficients.tobytes() == study.coefficients.tobytes()


def test_runs_that_cannot_be_made_are_rows_with_their_reason() -> None:
    study = made(replace(PLAN, count=2))
    # two modes at eleven places are 24 numbers: too few for 40 coefficients, enough for 10
    each, runs = study.cells[2:]
    assert (each.n_failed, each.suspected, each.coefficient_error, each.coverage) == (2, 0.0, None, None)
    assert study.runs[0].stopped_because == "24 measured numbers cannot determine 40 coefficients"
    assert not study.runs[0].converged
    assert runs.n_failed == 0
    assert study.coefficients.shape == (4, 40)


def test_a_method_of_two_stages_is_judged_too() -> None:
    study = made(replace(PLAN, method="inverse_eigensensitivity", divisions=(RUNS,), levels=LEVELS[:1]))
    (cell,) = study.cells
    assert cell.suspected == 1.0
    assert cell.coefficient_error is not None
    assert cell.coefficient_error[1] < 1e-3  # the tolerance of the last step is 1e-4


def test_who_stops_the_work_stops_it() -> None:
    def stop(_fraction: float, _message: str) -> None:
        raise CancelledError("enough")

    true = true_coefficients(BEAM, WRONG_BEAM, PLAN.parts)
    with pytest.raises(CancelledError):
        run_once(PLAN, 0, BEAM, assemble(WRONG_BEAM), true, stop)


def test_what_is_to_be_found_is_what_the_truth_multiplies() -> None:
    assert made(replace(PLAN, seeds=(0,), levels=LEVELS[:1], divisions=(RUNS,))).wrong == {
        "mass": {1: 2.0, 2: 2.0},
        "stiffness": {11: 2.0, 12: 2.0},
    }
    lossy = change(BEAM, [MemberChange((3,), MemberProperty.LOSS_FACTOR, value=0.055)])
    added = true_coefficients(BEAM, lossy, (Part.DAMPING,))["damping"]
    # the beam has 0.005 itself
    assert added[3] == pytest.approx(0.05, rel=1e-12)
    assert added[4] == 0.0


def test_sizes_are_to_be_found_where_they_are_asked_for() -> None:
    larger = change(
        BEAM,
        [
            MemberChange((3,), MemberProperty.AREA, factor=1.5),
            MemberChange((3,), MemberProperty.DENSITY, factor=2.0),
        ],
    )
    true = true_coefficients(BEAM, larger, (Part.AREA, Part.DENSITY, Part.MODULUS))
    assert [true[part][3] for part in ("area", "density", "modulus")] == pytest.approx([1.5, 2.0, 1.0])
    assert true["area"][4] == 1.0
    with pytest.raises(InvalidInputError, match="no thickness"):
        true_coefficients(BEAM, larger, (Part.THICKNESS,))


def test_a_truth_that_is_no_changed_copy_of_the_model_is_refused() -> None:
    shorter = replace(BEAM, members=BEAM.members[:-1], nodes={n: p for n, p in BEAM.nodes.items() if n < 21})
    with pytest.raises(InvalidInputError, match="other members") as error:
        true_coefficients(BEAM, shorter, (Part.MASS,))
    assert error.value.context["field"] == "truth_id"


def test_bending_apart_from_extension_needs_parts_of_its_own() -> None:
    bent = change(BEAM, [MemberChange((3,), MemberProperty.BENDING_STIFFNESS, factor=2.0)])
    with pytest.raises(InvalidInputError) as error:
        true_coefficients(BEAM, bent, (Part.STIFFNESS,))
    assert error.value.context == {"field": "parts", "value": "stiffness", "allowed": ["axial", "bending"]}
    assert true_coefficients(BEAM, bent, (Part.BENDING,))["bending"][3] == 2.0


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"method": "baruch"}, "method"),
        ({"levels": (LEVELS[0], LEVELS[0])}, "levels"),
        ({"divisions": (EACH, EACH)}, "divisions"),
        ({"divisions": (EACH, Division("mass", parameterise([(1,)], ["mass"])))}, "divisions"),
        ({"seeds": (1, 2, 1)}, "seeds"),
        ({"seeds": ()}, "seeds"),
        ({"seeds": tuple(range(501))}, "seeds"),
    ],
)
def test_plans_that_mean_nothing_are_refused_by_field(changed: dict[str, object], field: str) -> None:
    with pytest.raises(InvalidInputError) as error:
        replace(PLAN, **changed)  # type: ignore[arg-type]
    assert error.value.context["field"] == field


@pytest.mark.parametrize("method", LOCATORS)
def test_a_method_that_only_locates_is_judged_by_its_suspects_and_its_one_step(method: str) -> None:
    study = made(replace(PLAN, method=method, options=LocationOptions(), levels=LEVELS[:1], seeds=(3,)))
    for run, row, division in zip(study.runs, study.coefficients, (EACH, RUNS), strict=True):
        assert run.succeeded
        assert not run.converged
        assert (run.frequency_error, run.coverage) == (None, None)
        alone = locate(BEAM, division.parameterisation, method, modes_of(WRONG_BEAM, 8, BEAM_DOFS))
        assert run.suspected == alone.suspected
        found = [1 + change for part in alone.changes.values() for change in part.values()]
        np.testing.assert_array_equal(row, found)
    assert study.cells[0].n_failed == 0


def test_coefficients_that_are_added_one_by_one_hold_every_wrong_one_of_exact_modes() -> None:
    plan = replace(PLAN, method="zhang_subspace", options=LocationOptions(), levels=LEVELS[:1])
    each, _ = made(plan).cells
    assert each.suspected == 1.0
    # one linear step from a model wrong by a factor of two
    assert each.coefficient_error is not None
    assert each.coefficient_error[0] > 0.01


def test_a_method_on_matrices_has_no_coefficients_to_judge() -> None:
    with pytest.raises(InvalidInputError, match="no method called 'baruch' corrects") as caught:
        replace(PLAN, method="baruch")
    assert caught.value.context["field"] == "method"

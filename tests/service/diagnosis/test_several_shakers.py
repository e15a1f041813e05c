"""Several shakers at once: the same is named as by one, and with nothing hidden random error is left."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.held_out import select_held_out
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.predicting.unmeasured import unmeasured_inertance
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual, gap_errors
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.result_localisation import GapPattern
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.change import Change
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.expected import noise_free, with_noise
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure, measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra
from tests.rigs import beam_system, dofs, steel_beam

KINDS = ["stiffness_error", "extra_mass", "gain_error", "exciter_armature", "force_noise"]
HEAVY = Exciter(armature_mass=0.05)
SEEDS = range(5)


def shakers(
    *,
    drives: Sequence[int] = (1, 16),
    exciter: Exciter = HEAVY,
    excitation: str = "periodic_random",
    roving: bool = False,
    averages: int = 30,
) -> RigSetup:
    """Return a rig with shakers whose armatures tie their forces at resonances: 101 lines to 400 Hz."""
    return RigSetup(
        dofs(*drives),
        dofs(1, 5, 9, 13, 16, 21),
        exciter=exciter,
        accelerometers=Accelerometers(mass=0.01, roving=roving),
        noise=Noise(1e-4, 1e-4),
        analyser=Analyser(
            frequency_max=400.0, n_lines=101, averages=averages, excitation=ExcitationSetting(excitation)
        ),
    )


def shaken_beam(
    setup: RigSetup, effects: Sequence[Effect] = (), *, route: Route = Route.DRAWN, seed: int = 0
) -> Measurement:
    """Return a test of the beam of chapter 5."""
    return measure(steel_beam(), setup, effects, route=route, rng=np.random.default_rng(seed))


def unmodified(test: Measurement) -> tuple[Observed, Residual]:
    """Return the spectra of a test and their residual without added effects."""
    observed = observe(test, (), fraction=0.0)
    return observed, SingleTestPredictor.of(steel_beam(), test.setup, observed).residual(())


@pytest.mark.parametrize("route", [Route.DRAWN, Route.SAMPLED])
@pytest.mark.parametrize(
    ("hidden", "size"),
    [
        (StiffnessError(Members((6,)), 0.9), 0.9),
        (ExtraMass(Dof(9, "Y"), 0.03), 0.03),
        (GainError(Channels((Dof(5, "Y"),)), 1.05), 1.05),
        (GainError(Dof(16, "Y"), 1.05), 1.05),
        (ExciterArmature(Dof(16, "Y"), 0.03), 0.03),
    ],
    ids=["stiffness", "mass", "response gain", "force gain", "armature"],
)
def test_what_is_hidden_is_named_at_its_place(hidden: Effect, size: float, route: Route) -> None:
    found = diagnose(steel_beam(), shaken_beam(shakers(), [hidden], route=route), suspects=KINDS)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, hidden.at)
    (number,) = step.effect.parameters.values()
    # four standard errors, one time in 16,000 beyond
    assert abs(number.value - size) < 4 * number.standard_error


@pytest.mark.parametrize("route", [Route.DRAWN, Route.SAMPLED])
@pytest.mark.parametrize("seed", SEEDS)
def test_with_nothing_hidden_random_error_is_left(seed: int, route: Route) -> None:
    found = diagnose(steel_beam(), shaken_beam(shakers(), route=route, seed=seed), suspects=KINDS)
    assert found.verdict is Verdict.NOTHING_MISSING
    # three standard errors, one time in 400 beyond
    assert abs(found.remaining_gap - 1) < 3 * found.remaining_scatter


@pytest.mark.parametrize("force_noise", [1e-6, 1e-2])
@pytest.mark.parametrize("route", [Route.DRAWN, Route.SAMPLED])
def test_standard_errors_are_those_of_the_scatter(route: Route, force_noise: float) -> None:
    """Forces tied by armatures, and noise of them in all responses: errors are correlated, and counted so."""
    setup, mass = replace(shakers(), noise=Noise(force_noise, 1e-4)), ExtraMass(Dof(9, "Y"), 0.03)
    deviations = []
    for seed in range(25):
        test = shaken_beam(setup, [mass], route=route, seed=seed)
        observed = observe(test, (), fraction=0.0)
        best = fit(SingleTestPredictor.of(steel_beam(), setup, observed), [mass])
        (found,) = best.effects
        deviations.append((found.parameters["mass"] - 0.03) / best.errors[0]["mass"])
    # the root mean square of 25 normal numbers scatters by 0.14: three of them; 2.4 if taken as independent
    assert float(np.sqrt(np.mean(np.square(deviations)))) == pytest.approx(1.0, abs=0.42)


@pytest.mark.parametrize("averages", [8, 30])
@pytest.mark.parametrize("roving", [False, True])
def test_the_gap_of_each_part_is_one_by_its_random_error(roving: bool, averages: int) -> None:
    gaps = []
    for seed in SEEDS:
        observed, residual = unmodified(shaken_beam(shakers(roving=roving, averages=averages), seed=seed))
        errors = gap_errors(observed, residual, observed.usable)
        gaps.append([(gap - 1) / errors[part] for part, gap in residual.gaps(observed.usable).items()])
    # the mean of five has a standard deviation of 1/sqrt(5): four of them
    assert np.abs(np.mean(gaps, axis=0)).max() < 4 / np.sqrt(len(SEEDS))


@pytest.mark.parametrize("roving", [False, True])
def test_the_prediction_of_each_frf_is_the_measured_one(roving: bool) -> None:
    observed, residual = unmodified(shaken_beam(shakers(roving=roving), route=Route.EXPECTED))
    # one part in 1e-6, the least random error of any value: half of it is rounding of the receptances
    assert max(np.abs(part[1:]).max() for name, part in residual.parts.items() if name != "response") < 0.5
    assert observed.force is not None
    assert observed.force.shape[1] == (12 if roving else 2)


def test_the_order_of_the_shakers_changes_nothing() -> None:
    gaps, squares = [], []
    for setup in (shakers(), shakers(drives=(16, 1))):
        observed, residual = unmodified(
            shaken_beam(setup, [ExtraMass(Dof(9, "Y"), 0.03)], route=Route.EXPECTED)
        )
        gaps.append(residual.gaps(observed.usable))
        vector = residual.vector(observed.fitted)
        squares.append(float(vector @ vector))
    assert gaps[0] == pytest.approx(gaps[1], rel=1e-6)  # rounding of inverse matrices at resonances
    assert squares[0] == pytest.approx(squares[1], rel=1e-6)


def test_a_response_spectrum_counts_once_however_many_forces_cause_it() -> None:
    observed, residual = unmodified(shaken_beam(shakers()))
    assert residual.response is not None
    usable = observed.usable
    n_lines = int(usable[:, 0].sum())
    assert len(residual.vector(usable)) == n_lines * (2 * 12 + 2 + 6)  # FRFs, forces, responses
    assert int(residual.mask_of("response", usable).sum()) == n_lines * 6


def test_levels_that_nobody_declared_leave_random_error_alone() -> None:
    driven = shakers(exciter=Exciter())
    open_levels = replace(
        driven,
        noise=Noise(None, None),
        analyser=replace(
            driven.analyser, excitation=replace(driven.analyser.excitation, level=None, shape="unknown")
        ),
    )
    quieter = GainError(Dof(16, "Y"), 0.5)  # a force of half the size, with its own gauge right
    test = shaken_beam(driven, [quieter])
    values = test.frf.values * [1.0, 0.5]
    test = replace(test, frf=replace(test.frf, values=values), setup=open_levels)
    observed, residual = unmodified(test)
    assert residual.parts.keys() == {"frf", "force", "response"}
    for gap in residual.gaps(observed.usable).values():
        # the least of the parts has 200 real numbers, and so a standard deviation of 0.1: three of them
        assert gap == pytest.approx(1.0, abs=0.3)


def test_forces_with_a_common_cause_are_correlated_as_measured() -> None:
    """Sources of unknown spectrum that follow each other: noise of a force biases FRFs to both."""
    setup = replace(shakers(exciter=Exciter()), noise=Noise(1e-2, 1e-4))
    bench = chain(beam_system(), setup)
    clean = noise_free(bench)
    whole, independent = with_noise(bench, clean), clean[..., :4].reshape(1, 101, 2, 2)
    tie = 0.9 * np.exp(0.01j * whole.freq)
    ties = np.stack([np.ones_like(tie), tie, tie.conj(), np.ones_like(tie)], axis=1).reshape(101, 2, 2)
    h, signal = np.linalg.solve(independent, whole.fx), independent[..., :1, :1] * ties
    powers = [(forces @ h * h.conj()).sum(axis=2).real for forces in (independent, signal)]
    tied = replace(
        whole, ff=whole.ff - independent + signal, fx=signal @ h, xx=whole.xx - powers[0] + powers[1]
    )
    excitation = replace(setup.analyser.excitation, level=None, shape="unknown")
    log_book = replace(
        setup, noise=Noise(None, None), analyser=replace(setup.analyser, excitation=excitation)
    )
    for seed in SEEDS:
        drawn = wishart_spectra(tied, np.random.default_rng(seed), signal=signal)
        observed, residual = unmodified(replace(measurement_of(drawn, setup), setup=log_book))
        errors = gap_errors(observed, residual, observed.usable)
        for part, gap in residual.gaps(observed.usable).items():
            # four standard errors; as if independent the gap of FRFs was 1.8, ten of them
            assert abs(gap - 1) < 4 * errors[part]


@pytest.mark.parametrize("powers_known", [True, False])
def test_forces_of_unknown_cross_spectra_are_taken_as_uncorrelated(powers_known: bool) -> None:
    setup = shakers(exciter=Exciter())
    test = replace(shaken_beam(setup), force_cross_spectra=None)
    test = test if powers_known else replace(test, force_spectrum=None)
    observed, residual = unmodified(test)
    # 100 lines of 12 complex FRFs have a mean square of 1 within 0.03: three standard deviations
    assert residual.gaps(observed.usable)["frf"] == pytest.approx(1.0, abs=0.1)
    (note,) = [note for note in limitations(test, observed) if "cross spectra" in note]
    assert ("of equal power" in note) is not powers_known


def test_responses_are_held_out_with_their_frfs_to_all_forces() -> None:
    test = shaken_beam(shakers())
    chosen, unmeasured = select_held_out(steel_beam(), test, 0.34, (Dof(16, "Y"), Dof(3, "Y")), 0)
    assert FrfSelection(Dof(16, "Y")) in chosen
    assert len(chosen) == 2
    assert unmeasured == (Dof(3, "Y"),)
    observed = observe(test, chosen, fraction=0.34)
    assert observed.held_out.sum() == 4
    for _ in range(3):
        drawn, _ = select_held_out(steel_beam(), test, 0.34, (), 0)
        assert not {FrfSelection(Dof(1, "Y")), FrfSelection(Dof(16, "Y"))} & set(drawn), "drive points"


@pytest.mark.parametrize("roving", [False, True])
def test_curves_have_a_force_spectrum_a_shaker_and_a_response_spectrum_a_response(roving: bool) -> None:
    test = shaken_beam(shakers(roving=roving), [StiffnessError(Members((6,)), 0.9)])
    found = diagnose(steel_beam(), test, suspects=["stiffness_error"], hold_out=[Dof(5, "Y"), Dof(3, "Y")])
    curves = found.curves
    np.testing.assert_array_equal(curves.measured, test.frf.values)
    assert curves.held_out.shape == (6, 2)
    assert curves.predicted is not None
    assert curves.predicted.shape == (101, 1, 2)
    assert curves.force is not None
    assert curves.incoherent is not None
    assert (curves.force.measured.shape[1], curves.incoherent.measured.shape[1]) == (12 if roving else 2, 6)
    assert test.force_spectrum is not None
    placed = curves.force.measured.reshape(101, 2, -1).swapaxes(1, 2)
    ratio = placed / (test.force_spectrum if roving else test.force_spectrum[:, :1])
    # the expectation of a logarithm is unbiased by one factor for all
    np.testing.assert_allclose(ratio, ratio[0, 0, 0], rtol=1e-12)


def test_frfs_at_unmeasured_points_are_those_of_the_model() -> None:
    setup = shakers()
    observed = observe(shaken_beam(setup), (), fraction=0.0)
    predictor = SingleTestPredictor.of(steel_beam(), setup, observed)
    at_measured = unmeasured_inertance(predictor, (), dofs(5, 9))
    exact = replace(setup, noise=Noise())
    test = shaken_beam(exact, route=Route.EXPECTED)
    # accelerometers of 10 g sit where they were in both: rounding of matrices at resonances
    np.testing.assert_allclose(at_measured[1:], test.frf.values[1:, 1:3], rtol=1e-6)


def test_evidence_has_the_force_of_each_frf() -> None:
    test = shaken_beam(shakers())
    observed = observe(test, (), fraction=0.0)
    evidence = collect_evidence(SingleTestPredictor.of(steel_beam(), test.setup, observed), ())
    assert evidence.force is not None
    assert evidence.force.shape == evidence.frf.shape == (101, 12)
    assert 0 <= EFFECTS["exciter_armature"].signature(evidence) <= 1  # compares the parts' gaps


@pytest.mark.parametrize(
    ("kind", "places"),
    [
        ("exciter_armature", [None, Dof(1, "Y"), Dof(16, "Y")]),
        ("force_noise", [None, Dof(1, "Y"), Dof(16, "Y")]),
        ("stinger_bending", [None, Dof(1, "Y"), Dof(16, "Y")]),
        ("accelerometer_mass", [None]),
    ],
)
def test_what_sits_at_a_drive_point_is_suspected_at_each(kind: str, places: list[Place]) -> None:
    setup = shakers()
    observed = observe(shaken_beam(setup), (), fraction=0.0)
    system = SingleTestPredictor.of(steel_beam(), setup, observed).system
    assert list(EFFECTS[kind].places(system, setup)) == places
    assert list(EFFECTS["exciter_armature"].places(system, replace(setup, drives=dofs(1)))) == [None]


@pytest.mark.parametrize(
    "change", [Change(drive=Dof(9, "Y")), Change(exciter="hammer"), Change(level_factor=3.0)]
)
def test_a_further_test_with_one_shaker_or_a_hammer_is_explained_with_it(change: Change) -> None:
    soft, setup = StiffnessError(Members((6,)), 0.9), shakers()
    further = FollowUp(shaken_beam(change.applied(setup), [soft], seed=1), change)
    found = diagnose(
        steel_beam(), shaken_beam(setup, [soft]), suspects=["stiffness_error"], follow_ups=[further]
    )
    assert found.verdict is Verdict.EXPLAINED
    assert found.steps[0].effect.at == Members((6,))
    assert abs(found.remaining_gap - 1) < 3 * found.remaining_scatter


@pytest.mark.parametrize(
    ("node", "sign", "words"),
    [
        (
            5,
            GapPattern.ONE_RESPONSE,
            "only one response, 5:+Y, disagrees; all others agree within random error and tolerances",
        ),
        (
            16,
            GapPattern.DRIVE_POINT_ONLY,
            "only the drive point, 16:+Y, disagrees; all others agree within random error and tolerances",
        ),
    ],
)
def test_a_response_that_disagrees_alone_does_so_for_all_forces(
    node: int, sign: GapPattern, words: str
) -> None:
    test = shaken_beam(shakers(), [GainError(Channels((Dof(node, "Y"),)), 1.05)])
    located = diagnose(steel_beam(), test, suspects=["extra_mass"], max_effects=1).located
    assert sign in located.signs
    assert words in located.words


def test_the_report_draws_responses_and_every_drive_point() -> None:
    test = shaken_beam(shakers(), [GainError(Channels((Dof(5, "Y"),)), 1.05)])
    page = report(diagnose(steel_beam(), test, suspects=["gain_error"]))
    assert "6 responses to simultaneous forces at 1:+Y, 16:+Y" in page
    assert "drive points (arrows) and responses" in page
    assert "5:+Y / 16:+Y reads 5" in page
    sketch = re.search(r'<svg[^>]*aria-label="structure with.*?</svg>', page, re.DOTALL)
    assert sketch is not None
    assert sketch[0].count(" node") == 6
    assert not re.search("hammer|struck", page)


def test_two_shakers_follow_a_test_with_the_second_of_them() -> None:
    soft, setup = StiffnessError(Members((6,)), 0.9), shakers()
    first = shaken_beam(replace(setup, drives=setup.drives[1:]), [soft])
    further = FollowUp(shaken_beam(setup, [soft], seed=1))
    found = diagnose(steel_beam(), first, suspects=["stiffness_error"], follow_ups=[further])
    assert found.verdict is Verdict.EXPLAINED
    assert found.steps[0].effect.at == Members((6,))
    assert abs(found.remaining_gap - 1) < 3 * found.remaining_scatter


@pytest.mark.parametrize("excitation", ["chirp", "impact"])
def test_shakers_with_one_signal_are_refused(excitation: str) -> None:
    test = shaken_beam(shakers())
    setup = shakers(excitation=excitation)
    with pytest.raises(InvalidInputError, match="cannot be distinguished") as refused:
        diagnose(steel_beam(), replace(test, setup=setup))
    assert refused.value.context["field"] == "excitation.kind"


def test_too_few_averages_for_so_many_forces_are_refused() -> None:
    test = replace(shaken_beam(shakers()), averages=3.0)
    with pytest.raises(InvalidInputError, match="averages") as refused:
        observe(test, (), fraction=0.0)
    assert refused.value.context["allowed"] == "> 3; or noise_floor, the relative random error of the FRFs"

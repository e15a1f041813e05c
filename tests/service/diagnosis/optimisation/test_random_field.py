"""Tests of smooth deviations of members: their expansion, and models that are a little wrong."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Members
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.random_field import RandomField
from modallab.diagnosis.optimisation.settings import RANDOM_FIELD
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Verdict
from modallab.effects.extra_mass import ExtraMass
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Member, Section, Structure
from modallab.rig.effect import Effect
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.diagnosing import model, rig

# half a period of a sine and a straight line: no shapes of the expansion, of its size
STIFFNESS = 1 + 0.006 * np.sin(np.pi * (np.arange(8) + 0.5) / 8 - 0.4)
MASS = 1 + 0.005 * np.linspace(-1, 1, 8)
VARIATION = Tolerances(modulus_variation=0.005, density_variation=0.005)
KINDS = ["extra_mass", "ground_spring", "stiffness_error", "density_error"]


def a_little_wrong() -> Structure:
    members = (
        replace(
            member,
            axial_factor=member.axial_factor * k,
            bending_factor=member.bending_factor * k,
            mass_factor=member.mass_factor * m,
        )
        for member, k, m in zip(model().all_members, STIFFNESS, MASS, strict=True)
    )
    return model().of_members(members)


def measured(*hidden: Effect) -> Measurement:
    return measure(a_little_wrong(), rig(), hidden, route=Route.DRAWN, rng=np.random.default_rng(2))


def fine_beam(n_elements: int) -> Structure:
    return beam(
        length=1.0, n_elements=n_elements, section=Section(1e-4, 1e-9), material=Material(2e11, 7800.0)
    )


def test_the_expansion_reproduces_its_covariance() -> None:
    table = assemble(fine_beam(40)).members
    assert table is not None
    field = RandomField.of(table, 0.02)
    distance = np.subtract.outer(table.centres[:, 0], table.centres[:, 0])
    length = RANDOM_FIELD.correlation_length * np.ptp(table.centres[:, 0])
    covariance = np.exp(-(distance**2) / (2 * length**2))
    # The omitted eigenvalues are the mean variance that is omitted, times the number of members.
    for n, deviation in (
        (len(field), RANDOM_FIELD.omitted_deviation),
        (field.n_large, RANDOM_FIELD.small_deviation),
    ):
        omitted = np.linalg.eigvalsh(covariance - field.shapes[:n].T @ field.shapes[:n])
        assert 0.02**2 * omitted.sum() / 40 < deviation**2
        assert omitted.min() > -1e-9  # rounding of 40 eigenvalues of order 10
    assert field.n_large < 20
    assert len(field) < 30


def test_the_number_of_shapes_follows_from_the_structure_and_not_from_its_mesh() -> None:
    coarse, fine = (assemble(fine_beam(n)).members for n in (40, 160))
    assert coarse is not None
    assert fine is not None
    # The ends are half an element off.
    assert abs(len(RandomField.of(coarse, 0.02)) - len(RandomField.of(fine, 0.02))) <= 1


def test_a_small_deviation_needs_few_shapes() -> None:
    members = assemble(fine_beam(40)).members
    assert members is not None
    fields = [RandomField.of(members, deviation) for deviation in (1e-5, 0.002, 0.005, 0.02)]
    for numbers in ([field.n_large for field in fields], [len(field) for field in fields]):
        assert numbers == sorted(set(numbers))
    assert fields[0].n_large == 1


def test_members_of_different_bars_are_independent() -> None:
    # a T of two bars: 21 nodes along X, and 10 more from their middle on, with a bend of 10 degrees half way
    bend = np.radians(10.0)
    nodes = {i + 1: (0.1 * i, 0.0) for i in range(21)}
    height = np.arange(1, 11) * 0.1
    offset = np.tan(bend) * np.maximum(height - 0.5, 0.0)
    nodes |= {22 + i: (1.0 + float(x), float(y)) for i, (x, y) in enumerate(zip(offset, height, strict=True))}
    pairs = [*pairwise(range(1, 22)), *pairwise([11, *range(22, 32)])]
    section, material = Section(1e-4, 1e-9), Material(2e11, 7800.0)
    members = tuple(Member(i, pair, section, material) for i, pair in enumerate(pairs, 1))
    table = assemble(Structure(nodes=nodes, members=members)).members
    assert table is not None
    field = RandomField.of(table, 0.005)
    covariance = field.shapes.T @ field.shapes
    assert (np.abs(covariance[:20, 20:]) < 1e-9).all()  # rounding of eigenvectors
    # centres half a correlation length (0.2 m) apart, also across the bend; 1 % of the variance is omitted
    assert np.diag(covariance, 1)[[5, 24]] == pytest.approx(np.exp(-(0.5**2) / 2), abs=0.05)


def test_elements_of_a_plate_are_one_part() -> None:
    material = Material(2.09e11, 7800.0)
    made = plate(length=0.6, width=0.6, thickness=0.004, n_elements=(8, 8), material=material)
    table = assemble(made).members
    assert table is not None
    field = RandomField.of(table, 0.005)
    covariance = field.shapes.T @ field.shapes
    from_centre = covariance[27] / covariance[27, 27]
    assert from_centre[[26, 28, 19, 35]] == pytest.approx(0.36, abs=0.15)  # 1.43 lengths; 40 shapes of 64
    assert abs(from_centre[7]) < 0.1  # a corner


def test_factors_of_members_act_as_members_of_other_factors() -> None:
    system = assemble(model()).with_member_factors(
        stiffness=tuple(STIFFNESS.tolist()), mass=tuple(MASS.tolist())
    )
    frequencies = system.modes(400.0).elastic().frequencies[:5]
    expected = assemble(a_little_wrong()).modes(400.0).elastic().frequencies[:5]
    np.testing.assert_allclose(
        frequencies, expected, rtol=1e-9
    )  # two eigensolutions of nearly equal matrices


def test_a_model_that_is_a_little_wrong_everywhere_lacks_nothing_within_its_tolerances() -> None:
    test = measured()
    assert diagnose(model(), test, suspects=["extra_mass"]).verdict is Verdict.UNEXPLAINED
    diagnosis = diagnose(model(), test, suspects=KINDS, tolerances=VARIATION)
    assert diagnosis.verdict is Verdict.NOTHING_MISSING
    for name, true in (("modulus_variation", STIFFNESS), ("density_variation", MASS)):
        rows = [row for row in diagnosis.tolerated if row.name == name]
        assert [row.at for row in rows] == [Members((number,)) for number in range(1, 9)]
        deviations = np.array([row.value for row in rows]) - true
        # standard errors hold the prior: most members are told only by what their neighbours are
        errors = np.array([row.standard_error for row in rows])
        assert (np.abs(deviations) < 4 * errors).all()
        assert errors.max() < 0.005  # a standard deviation of the prior: the data add to it


def test_an_effect_is_named_in_a_model_that_is_a_little_wrong() -> None:
    hidden = ExtraMass(at=Dof.parse("4:+Y"), mass=0.05)
    diagnosis = diagnose(model(), measured(hidden), suspects=KINDS, tolerances=VARIATION)
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert [(step.effect.kind, step.effect.at) for step in diagnosis.steps] == [("extra_mass", hidden.at)]
    (mass,) = diagnosis.steps[0].effect.parameters.values()
    assert mass.value == pytest.approx(0.05, abs=4 * mass.standard_error)
    assert mass.standard_error > 1e-4  # 0.2 % of the mass: what the tolerances leave, not the lines alone


def test_a_deviation_on_its_bound_does_not_excuse_held_out_data() -> None:
    narrow = Tolerances(modulus_variation=2e-4, density_variation=2e-4)
    test = measured()
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    predictor = predictor.with_nuisances(nuisance_parameters(narrow, predictor.system, predictor.setup))
    bounded = fit(predictor, ())
    on_bounds = np.abs(bounded.nuisance_position) > predictor.nuisances.limits - 1e-9  # rounding of a bound
    assert on_bounds.mean() > 0.5
    # below noise: those few parameters that are off their bounds have errors of at most 0.02 %
    assert bounded.prediction_variance["frf"] < 1
    assert bounded.residual.gap(predictor.observed.held_out_mask) > 2


def test_a_model_without_members_is_refused() -> None:
    system = assemble(model()).folded()
    with pytest.raises(InvalidInputError) as caught:
        nuisance_parameters(VARIATION, replace(system, members=None), rig())
    assert caught.value.context["field"] == "tolerances.modulus_variation"
